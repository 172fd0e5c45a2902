// What is seen through the periscope: sky, sea and ships, the wires, and water on the glass.
import { Chart, stroke } from "../charts/chart.js";
import { Sea } from "./sea.js";
import { Water } from "./water.js";
import { bearing } from "../draw.js";
import { distanceOf, drawShip } from "./ships.js";
import { drawBubbles, drawDrops, drawSky } from "./glass.js";

const DEGREE = Math.PI / 180;
const MINUTE = DEGREE / 60;
const EARTH = 6371e3 / 0.8279; // [m] as the session has it
const DROPS = 1.5; // [s] on the glass after it was washed over
const WINDOW = 0.12; // [m] half the height of the glass
/** @type {Record<string, number>} width of the view [rad] by power */
const FIELDS = { 1.5: 32 * DEGREE, 6: 8 * DEGREE };
const FINEST = 720; // [px] of a side: a soft picture, which changes whole fifteen times a second
const OPEN = 3; // ticks either side of the middle, between which the level wire is left out
const OVERLAP = 1.06; // of what is drawn over what is seen, for a view that rolls

/**
 * @typedef {import("./ships.js").Sight} Sight
 * @typedef {import("./water.js").Colours & { high: string, low: string, ship: number, lamps: boolean,
 *   under: string, wire: string, ink: string, stars: boolean }} Light of a time of day
 * @typedef {object} Scene what there is to see
 * @property {string} view down, washed, shakes, clear, or "" where there is no periscope
 * @property {string} words where nothing is seen
 * @property {number} power
 * @property {number} train [rad]
 * @property {number} bearing [deg] under the wire
 * @property {number} head [m] over the mean water
 * @property {number} roll [rad] of the boat as it is seen that way, clockwise
 * @property {number} seconds of the boat's time
 * @property {Sight[]} ships
 * @property {string} light of the session: a name of LIGHTS
 * @property {boolean} still nothing is to move by itself
 *
 * @typedef {{ scene: Scene, light: Light, radius: number, name: string }} Wired wires and tube, and
 *   the name of their light and power
 */

/** @type {Record<string, Light>} */
const LIGHTS = {
  day: {
    ...{ high: "#6f9dc4", low: "#dfe9ee", far: "#a9bfc9", dark: "#14424f", mean: "#2f6a78" },
    ...{ light: "#8fb3bb", foam: "#ffffff", under: "#1e6a66", wire: "#101418", ink: "#f4f1e4" },
    ...{ ship: 1, lamps: false, stars: false },
  },
  dusk: {
    ...{ high: "#26405f", low: "#e3a276", far: "#8d7f80", dark: "#0d1f2b", mean: "#2b4553" },
    ...{ light: "#a08d86", foam: "#e8dcd3", under: "#123f44", wire: "#0b0d10", ink: "#f4f1e4" },
    ...{ ship: 0.42, lamps: true, stars: false },
  },
  night: {
    ...{ high: "#04060b", low: "#151c28", far: "#10161f", dark: "#020406", mean: "#0a1017" },
    ...{ light: "#1d2733", foam: "#4a5765", under: "#03100f", wire: "#8c2019", ink: "#e8352a" },
    ...{ ship: 0.06, lamps: true, stars: true },
  },
};

/** `<scope-view label>`: `show(scene)` draws; `sea` has the waves. */
class ScopeView extends Chart {
  constructor() {
    super();
    this.finest = FINEST;
    this.clears = false; // all of it is painted
    this.sea = new Sea();
    this.water = new Water();
    /** @type {Scene | null} */
    this.scene = null;
    this.mask = document.createElement("canvas");
    this.made = ""; // of what size, power and light it is
    this.looks = ""; // of the scene that is drawn
    this.washed = -Infinity; // [s] when the glass was last under water
    this.eye = 0; // [m] over the waves
  }

  connectedCallback() {
    super.connectedCallback();
    this.canvas?.getContext("2d", { alpha: false }); // what is behind it need not be mixed in
  }

  /** Draws a scene, if it looks otherwise than the one before. @param {Scene} scene */
  show(scene) {
    const looks = looksOf(scene);
    const same = looks === this.looks && scene.ships === this.scene?.ships;
    this.scene = scene;
    this.looks = looks;
    if (!same) this.draw();
  }

  draw() {
    const { scene } = this;
    const area = scene && this.begin();
    if (!scene || !area) return;
    const { pen, width, height } = area;
    const radius = 0.5 * Math.min(width, height) - 2;
    const light = LIGHTS[scene.light];
    const shown = scene.view === "" || scene.view === "down" ? "dark" : this.look(scene, area, radius, light);
    this.dataset.view = shown;
    if (shown === "dark") this.tell(area, scene.words, light.ink);
    else {
      this.cover(area, { scene, light, radius, name: `${scene.light} ${scene.power}` });
      pen.lineWidth = 1.2;
      tape(area, { scene, radius, scale: scaleOf(scene, radius), ink: light.ink });
    }
  }

  /** Draws what is seen; returns what is in its way. @param {Scene} scene @param {import("../charts/chart.js").Area} area @param {number} radius @param {Light} light */
  look(scene, { pen, width, height }, radius, light) {
    const level = this.sea.level(0, 0);
    this.eye = scene.head - level;
    const field = FIELDS[scene.power] ?? FIELDS[1.5];
    const scale = scaleOf(scene, radius);
    pen.save();
    pen.translate(0.5 * width, 0.5 * height);
    pen.rotate(scene.roll + (scene.view === "shakes" ? 0.03 * Math.sin(41 * scene.seconds) : 0));
    if (scene.view === "shakes") pen.translate(0, 0.02 * radius * Math.sin(53 * scene.seconds));
    const eye = Math.max(this.eye, 0.05);
    const reach = radius * 1.05;
    drawSky(pen, { scene, light, scale, reach, field });
    const outlook = {
      ...{ pen, eye, level, train: scene.train, field: field * OVERLAP, centre: 0, horizontal: 0 },
      ...{ scale, foot: reach, colours: light, seconds: scene.still ? 0 : scene.seconds },
    };
    this.water.draw(this.sea, outlook, this.among(scene, pen, scale, light, eye));
    pen.restore();
    return this.onGlass(scene, pen, [0.5 * width, 0.5 * height, radius], light);
  }

  /** Returns the ships as they are to be drawn among the waves, the nearest first. @param {Scene} scene @param {CanvasRenderingContext2D} pen @param {number} scale @param {Light} light @param {number} eye */
  among(scene, pen, scale, light, eye) {
    const canvas = {
      ...{ pen, light: light.ship, haze: light.low, lamps: light.lamps },
      x: (/** @type {number} */ beside) => beside * scale,
      y: (/** @type {number} */ elevation) => -elevation * scale,
    };
    const field = FIELDS[scene.power] ?? FIELDS[1.5];
    const seen = scene.ships.flatMap((ship) => {
      const train = turned(ship.train - scene.train);
      return Math.abs(train) < 0.6 * field + ship.span ? [{ ...ship, train }] : [];
    });
    this.dataset.ships = String(seen.length);
    return seen
      .map((ship) => ({ distance: nearness(ship, eye), draw: () => drawShip(canvas, ship) }))
      .toSorted((one, other) => one.distance - other.distance);
  }

  /** Draws water on the glass; returns what is in the way. @param {Scene} scene @param {CanvasRenderingContext2D} pen @param {number[]} circle @param {Light} light */
  onGlass(scene, pen, circle, light) {
    const { seconds } = scene;
    const covered = Math.min(Math.max(0.5 - this.eye / (2 * WINDOW), 0), 1);
    if (covered > 0) this.washed = seconds;
    if (covered > 0) drawBubbles(pen, circle, { covered, light, seconds, depth: Math.max(-this.eye, 0) });
    if (covered >= 1) return "washed";
    const since = seconds - this.washed;
    if (since >= 0 && since < DROPS) {
      drawDrops(pen, circle, 1 - since / DROPS, scene.still ? 0 : since);
      return "drops";
    }
    return scene.view;
  }

  /** Lays the wires and the black tube over the view, pixel on pixel. @param {import("../charts/chart.js").Area} area @param {Wired} wired */
  cover({ pen, width }, wired) {
    const { canvas } = pen;
    const ratio = canvas.width / width;
    const made = `${canvas.width} ${canvas.height} ${ratio} ${wired.name}`;
    if (this.made !== made) this.makeTube(canvas, ratio, wired);
    this.made = made;
    pen.save();
    pen.resetTransform();
    pen.drawImage(this.mask, 0, 0);
    pen.restore();
  }

  /** Draws the wires and the tube round the view, once for a size, a power and a light. @param {HTMLCanvasElement} canvas @param {number} ratio @param {Wired} wired */
  makeTube({ width, height }, ratio, wired) {
    const { mask } = this;
    [mask.width, mask.height] = [width, height];
    const pen = mask.getContext("2d");
    if (!pen) return;
    const [x, y] = [0.5 * width, 0.5 * height];
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    wires(pen, [x / ratio, y / ratio], wired);
    pen.resetTransform();
    const radius = Math.min(x, y) - 2;
    const shade = pen.createRadialGradient(x, y, 0.9 * radius, x, y, radius);
    shade.addColorStop(0, "#00000000");
    shade.addColorStop(1, "#000000");
    pen.fillStyle = shade;
    pen.fillRect(0, 0, width, height);
  }

  /** Writes words where nothing is seen. @param {import("../charts/chart.js").Area} area @param {string} words @param {string} ink */
  tell({ pen, width, height, size, face }, words, ink) {
    pen.fillStyle = "#000000";
    pen.fillRect(0, 0, width, height);
    pen.fillStyle = ink;
    pen.font = `500 ${size * 1.5}px ${face}`;
    pen.textAlign = "center";
    pen.fillText(words, 0.5 * width, 0.5 * height);
  }
}

/** Returns an angle from -pi to pi. @param {number} angle */
export function turned(angle) {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}

/** Returns how far away a ship is, by its waterline where that is seen [m]. @param {Sight} ship @param {number} eye */
function nearness(ship, eye) {
  const below = -ship.bottom;
  const left = below * below - (2 * eye) / EARTH;
  return left > 1e-9 ? EARTH * (below - Math.sqrt(left)) : distanceOf(ship);
}

/** Returns all of a scene that makes a difference to the picture, but its ships. @param {Scene} scene */
function looksOf({ view, words, power, train, bearing: towards, head, roll, seconds, light }) {
  if (view === "" || view === "down") return words;
  return [view, power, light, ...[train, towards, head, roll].map((each) => each.toFixed(4)), seconds.toFixed(3)].join();
}

/** Returns how large a radian is [px]. @param {Scene} scene @param {number} radius */
function scaleOf({ power }, radius) {
  return (2 * radius) / (FIELDS[power] ?? FIELDS[1.5]);
}

/** Draws the wires. @param {CanvasRenderingContext2D} pen @param {number[]} middle @param {Wired} wired */
function wires(pen, [x, y], { scene, light, radius }) {
  const scale = scaleOf(scene, radius);
  pen.strokeStyle = light.wire;
  pen.lineWidth = 1.2;
  stroke(pen, [x, y - radius, x, y + radius]);
  const [tick, every] = scene.power > 2 ? [10 * MINUTE, 6] : [DEGREE, 5];
  const open = OPEN * tick * scale; // a ship at the wire is not to be behind it
  for (const side of [-1, 1]) stroke(pen, [x + side * open, y, x + side * radius, y]);
  for (let i = 1; i * tick * scale < radius; i++) {
    const long = i % every ? 5 : 10;
    for (const side of [-1, 1]) {
      const at = side * i * tick * scale;
      if (i >= OPEN) stroke(pen, [x + at, y - long, x + at, y + long]);
      stroke(pen, [x - long, y + at, x + long, y + at]);
    }
  }
}

/** Draws the bearings along the foot of the view. @param {import("../charts/chart.js").Area} area @param {{ scene: Scene, radius: number, scale: number, ink: string }} how */
function tape({ pen, width, height, size, face }, { scene, radius, scale, ink }) {
  const x = 0.5 * width;
  const [half, top] = [0.5 * radius, 0.5 * height + 0.8 * radius];
  const high = 1.9 * size;
  pen.fillStyle = "#000000b0";
  pen.fillRect(x - half, top, 2 * half, high);
  const [step, named] = scene.power > 2 ? [0.5, 4] : [1, 5];
  pen.fillStyle = pen.strokeStyle = ink;
  pen.font = `500 ${size}px ${face}`;
  pen.textAlign = "center";
  const span = half / (scale * DEGREE);
  pen.beginPath();
  for (let i = Math.ceil((scene.bearing - span) / step); i * step <= scene.bearing + span; i++) {
    const at = x + (i * step - scene.bearing) * DEGREE * scale;
    pen.moveTo(at, top);
    pen.lineTo(at, top + (i % named ? 4 : 7));
    const clear = Math.abs(at - x) < half - size;
    if (i % named === 0 && clear) pen.fillText(bearing(i * step), at, top + high - 0.6 * size);
  }
  pen.stroke();
  pen.beginPath();
  pen.moveTo(x, top + 2);
  pen.lineTo(x - 5, top - 6);
  pen.lineTo(x + 5, top - 6);
  pen.fill();
}

customElements.define("scope-view", ScopeView);
