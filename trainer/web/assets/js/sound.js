// Sounds made by the page itself. Silent until somebody switches them on: browsers ask for a gesture.

const LENGTH = 0.16; // [s] of a tone
const LEVEL = 0.2;
/** @type {Record<import("./model/alerts.js").Rank, number[]>} pitches [Hz] of each rank */
const TONES = {
  emergency: [880, 880, 880, 880, 880],
  alarm: [880, 880, 880],
  warning: [660, 660],
  caution: [],
};
const BELL = [1200];

export class Sound {
  constructor() {
    this.on = false;
    /** @type {AudioContext | null} */
    this.context = null;
  }

  /** Switches sounds on or off; returns which. */
  toggle() {
    this.on = !this.on;
    this.context ??= this.on ? new AudioContext() : null;
    return this.on;
  }

  /** Tells an alert. @param {import("./model/alerts.js").Rank} rank */
  alert(rank) {
    this.play(TONES[rank]);
  }

  /** Strikes the telegraph's bell. */
  bell() {
    this.play(BELL);
  }

  /** @param {number[]} pitches */
  play(pitches) {
    const { context } = this;
    if (!this.on || !context) return;
    pitches.forEach((pitch, index) => {
      const at = context.currentTime + index * LENGTH * 1.6;
      const [tone, level] = [context.createOscillator(), context.createGain()];
      tone.frequency.value = pitch;
      level.gain.setValueAtTime(0, at);
      level.gain.linearRampToValueAtTime(LEVEL, at + 0.01);
      level.gain.setValueAtTime(LEVEL, at + LENGTH - 0.03);
      level.gain.linearRampToValueAtTime(0, at + LENGTH);
      tone.connect(level).connect(context.destination);
      tone.start(at);
      tone.stop(at + LENGTH);
    });
  }
}
