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
const HISS = { pitch: 900, level: 0.12, lag: 0.15 }; // of air: [Hz], -, [s]
const NOISE = 2; // [s] of noise, again and again

export class Sound {
  constructor() {
    this.on = false;
    /** @type {AudioContext | null} */
    this.context = null;
    this.blows = false; // air flows
    /** @type {GainNode | null} how loud the air is */
    this.hiss = null;
  }

  /** Switches sounds on or off; returns which. */
  toggle() {
    this.on = !this.on;
    this.context ??= this.on ? new AudioContext() : null;
    this.blow(this.blows);
    return this.on;
  }

  /** Tells an alert. @param {import("./model/alerts.js").Rank} rank */
  alert(rank) {
    this.play(TONES[rank]);
  }

  /** Strikes the bell once: somebody is called. */
  bell() {
    this.play(BELL);
  }

  /** Strikes it twice, as the telegraph does when it is rung. */
  telegraph() {
    this.play([...BELL, ...BELL]);
  }

  /** Lets air be heard as it flows into a tank. @param {boolean} flows */
  blow(flows) {
    this.blows = flows;
    const { context } = this;
    if (!context) return;
    const loud = flows && this.on;
    if (loud) this.hiss ??= hissOf(context);
    this.hiss?.gain.setTargetAtTime(loud ? HISS.level : 0, context.currentTime, HISS.lag);
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

/** Returns how loud a hiss is, which it begins in silence. @param {AudioContext} context */
function hissOf(context) {
  const noise = context.createBuffer(1, NOISE * context.sampleRate, context.sampleRate);
  noise.getChannelData(0).forEach((_, at, samples) => (samples[at] = 2 * Math.random() - 1));
  const [air, band, level] = [context.createBufferSource(), context.createBiquadFilter(), context.createGain()];
  Object.assign(air, { buffer: noise, loop: true });
  band.type = "bandpass";
  band.frequency.value = HISS.pitch;
  level.gain.value = 0;
  air.connect(band).connect(level).connect(context.destination);
  air.start();
  return level;
}
