// Real time: ticks at their deadlines. A tab that was asleep goes on from where it stood.

const ASLEEP = 2.5; // [s] late, from which on the tab was asleep: nothing is made up
const BURST = 40; // [ms] of work at most before others have their turn

export class Pacer {
  /**
   * @param {number} step [s]
   * @param {{ now: () => number, later: (call: () => void, wait: number) => void }} clock in ms
   * @param {{ tick: () => boolean, gap: (seconds: number) => void }} calls `tick` returns whether time goes on
   */
  constructor(step, clock, calls) {
    this.step = step;
    this.clock = clock;
    this.calls = calls;
    this.frozen = true;
    this.speed = 1;
    this.due = 0; // [ms] when the next tick is due
    this.turn = 0; // counts changes: a wait for another one is void
  }

  /** [ms] between ticks */
  get period() {
    return (1000 * this.step) / this.speed;
  }

  run() {
    if (!this.frozen) return;
    this.frozen = false;
    this.due = this.clock.now() + this.period;
    this.wait();
  }

  freeze() {
    this.frozen = true;
    this.turn += 1;
  }

  /** @param {number} speed */
  change(speed) {
    this.speed = speed;
    if (this.frozen) return;
    this.due = this.clock.now() + this.period;
    this.wait();
  }

  wait() {
    this.turn += 1;
    const { turn } = this;
    const call = () => {
      if (turn === this.turn) this.work();
    };
    this.clock.later(call, Math.max(this.due - this.clock.now(), 0));
  }

  /** Takes the ticks that are due. */
  work() {
    const woke = this.clock.now();
    const late = woke - this.due;
    if (late > 1000 * ASLEEP) {
      this.due = woke;
      this.calls.gap(late / 1000);
    }
    while (!this.frozen && this.due <= this.clock.now()) {
      this.due += this.period;
      if (!this.calls.tick()) this.freeze();
      if (this.clock.now() - woke > BURST) {
        this.due = Math.max(this.due, this.clock.now()); // slower than ordered, and no debt
        break;
      }
    }
    if (!this.frozen) this.wait();
  }
}
