// Ships as they are seen: hulls, houses, masts and lights, to scale by angles.

/**
 * @typedef {object} Sight a ship in sight; angles in radians
 * @property {string} type
 * @property {number} train off the bow, clockwise
 * @property {number} bottom elevation of her waterline, or of the horizon
 * @property {number} top elevation of the masthead
 * @property {number} aspect off her bow, to starboard positive, of who looks
 * @property {number} span of her length, seen abeam
 * @property {[string, number, number][]} lights colour, beside her middle, elevation
 *
 * @typedef {[number, number, number, number, number, string]} Block from and to along her, half
 *   width, from and to over the water, colour; lengths and half beams are 1, heights in metres
 * @typedef {{ length: number, beam: number, mast: number, deck: number, hull: string,
 *   blocks: Block[], masts: [number, number, number][], sail?: boolean }} Shape
 *
 * @typedef {{ pen: CanvasRenderingContext2D, light: number, haze: string, lamps: boolean,
 *   x: (beside: number) => number, y: (elevation: number) => number }} Canvas where she is drawn
 */

// Bow, shoulders and quarters, in half lengths and half beams.
const PLAN = [
  [1, 0],
  [0.72, 0.72],
  [0.4, 1],
  [-1, 0.86],
  [-1, -0.86],
  [0.4, -1],
  [0.72, -0.72],
];
const SHEER = 0.28; // by how much the deck is higher at the bow
const AIR = 16_000; // [m] in which haze takes a ship to the 1/e
/** @type {Record<string, Shape>} */
const SHAPES = {
  tanker: {
    ...{ length: 200, beam: 32, mast: 40, deck: 8, hull: "#6d2f2a" },
    blocks: [
      [-0.94, -0.86, 0.3, 8, 32, "#c9b26a"],
      [-0.86, -0.66, 0.9, 8, 24, "#d9d8d0"],
      [-0.82, -0.68, 0.98, 24, 30, "#e6e5de"],
      [-0.05, 0.05, 0.3, 8, 12, "#8d8577"],
    ],
    masts: [
      [-0.74, 30, 40],
      [0, 8, 21],
      [0.84, 9, 24],
    ],
  },
  cargo: {
    ...{ length: 140, beam: 21, mast: 34, deck: 7, hull: "#28435c" },
    blocks: [
      [-0.94, -0.86, 0.4, 7, 27, "#b6543c"],
      [-0.86, -0.66, 0.9, 7, 26, "#dedcd2"],
      [-0.6, -0.14, 0.92, 7, 15, "#9a4a39"],
      [-0.1, 0.34, 0.92, 7, 13, "#3f6f8b"],
      [0.38, 0.7, 0.72, 7, 15, "#7c8a52"],
    ],
    masts: [
      [-0.74, 26, 34],
      [-0.12, 7, 25],
      [0.36, 7, 25],
      [0.86, 9, 20],
    ],
  },
  ferry: {
    ...{ length: 120, beam: 20, mast: 32, deck: 10, hull: "#1f3f78" },
    blocks: [
      [-0.94, 0.8, 0.98, 10, 18, "#f0efea"],
      [-0.8, 0.64, 0.94, 18, 23, "#f7f6f2"],
      [-0.4, -0.2, 0.34, 23, 30, "#c2402f"],
      [0.4, 0.62, 1, 23, 26, "#e9e8e2"],
    ],
    masts: [[0.5, 26, 32]],
  },
  fishing: {
    ...{ length: 24, beam: 7, mast: 12, deck: 2.2, hull: "#2c5f4a" },
    blocks: [
      [0.05, 0.5, 0.7, 2.2, 5, "#e2e0d6"],
      [0.12, 0.4, 0.62, 5, 7.2, "#eceae2"],
      [-0.92, -0.84, 0.8, 2.2, 6.4, "#8a6a3b"],
    ],
    masts: [
      [0.1, 7, 12],
      [-0.3, 2.2, 9],
    ],
  },
  yacht: {
    ...{ length: 14, beam: 4.2, mast: 18, deck: 1.2, hull: "#e8e8e4", sail: true },
    blocks: [[-0.3, 0.3, 0.5, 1.2, 1.8, "#cfd3d4"]],
    masts: [[0.12, 1.2, 18]],
  },
  tug: {
    ...{ length: 32, beam: 11, mast: 18, deck: 3, hull: "#262b31" },
    blocks: [
      [-0.1, 0.6, 0.7, 3, 7.5, "#d8873c"],
      [0.1, 0.46, 0.6, 7.5, 11.5, "#e6e4da"],
      [-0.22, -0.1, 0.62, 7.5, 12, "#b04a32"],
    ],
    masts: [[0.16, 11.5, 18]],
  },
  submarine: {
    ...{ length: 70, beam: 10, mast: 8, deck: 2, hull: "#262b31" },
    blocks: [[0.16, 0.4, 0.24, 2, 8, "#262b31"]],
    masts: [],
  },
};
const LAMPS = /** @type {Record<string, string>} */ ({
  white: "#fff6dc",
  red: "#ff4632",
  green: "#3dff8f",
  yellow: "#ffc83d",
});

/** Returns how far away she looks [m], by the length of her type. @param {Sight} ship */
export function distanceOf({ type, span }) {
  return (SHAPES[type] ?? SHAPES.cargo).length / Math.max(span, 1e-6);
}

/** Draws a ship; what the horizon hides is cut off. @param {Canvas} canvas @param {Sight} ship */
export function drawShip(canvas, ship) {
  const shape = SHAPES[ship.type] ?? SHAPES.cargo;
  const distance = distanceOf(ship);
  const haze = 1 - Math.exp(-distance / AIR);
  const { pen } = canvas;
  pen.save();
  pen.beginPath();
  const [left, right] = [-1, 1].map((side) => canvas.x(ship.train + side * ship.span));
  const [top, bottom] = [canvas.y(ship.top) - 40, canvas.y(ship.bottom)];
  pen.rect(left, top, right - left, Math.max(bottom - top, 0) + 0.5);
  pen.clip();
  new Silhouette(canvas, ship, shape, haze).draw();
  pen.restore();
  if (canvas.lamps) for (const light of ship.lights) drawLamp(canvas, ship, light);
}

/** @param {Canvas} canvas @param {Sight} ship @param {[string, number, number]} light */
function drawLamp({ pen, x, y }, ship, [colour, beside, elevation]) {
  const [at, up] = [x(ship.train + beside), y(elevation)];
  pen.fillStyle = LAMPS[colour] ?? LAMPS.white;
  for (const [size, strength] of [
    [7, 0.14],
    [4, 0.3],
    [1.9, 1],
  ]) {
    pen.globalAlpha = strength;
    pen.beginPath();
    pen.arc(at, up, size, 0, 2 * Math.PI);
    pen.fill();
  }
  pen.globalAlpha = 1;
}

class Silhouette {
  /** @param {Canvas} canvas @param {Sight} ship @param {Shape} shape @param {number} haze */
  constructor(canvas, ship, shape, haze) {
    this.canvas = canvas;
    this.ship = ship;
    this.shape = shape;
    this.haze = haze;
    this.scale = ship.span / shape.length; // [rad] of a metre
    this.ahead = Math.cos(ship.aspect); // of who looks, along her and beside her
    this.beside = Math.sin(ship.aspect);
    this.water = ship.top - shape.mast * this.scale; // elevation of the waterline, hidden or not
  }

  draw() {
    const { blocks, masts, hull, deck, sail } = this.shape;
    this.body(PLAN, [0, deck], hull, SHEER);
    const near = ([from, to] = [0, 0]) => 0.5 * (from + to) * this.ahead;
    for (const block of blocks.toSorted((a, b) => near([a[0], a[1]]) - near([b[0], b[1]]))) {
      const [from, to, half, low, high, colour] = block;
      const corners = [
        [to, half],
        [from, half],
        [from, -half],
        [to, -half],
      ];
      this.body(corners, [low, high], colour, 0);
    }
    for (const mast of masts) this.mast(mast);
    if (sail) this.sails();
  }

  /** Returns where a point of her is seen. @param {number} along @param {number} side @param {number} height [m] */
  point(along, side, height) {
    const { length, beam } = this.shape;
    const off = 0.5 * (along * length * this.beside - side * beam * this.ahead);
    const { x, y } = this.canvas;
    return [x(this.ship.train + off * this.scale), y(this.water + height * this.scale)];
  }

  /**
   * Draws what stands on a plan from one height to another: the sides that are seen.
   * @param {number[][]} plan clockwise from above
   * @param {number[]} heights [m]
   * @param {string} colour
   * @param {number} sheer by which its front end is higher
   */
  body(plan, [low, high], colour, sheer) {
    plan.forEach(([along, side], at) => {
      const [next, beyond] = plan[(at + 1) % plan.length];
      const { length, beam } = this.shape;
      const [out, across] = [(beyond - side) * beam, -(next - along) * length];
      const size = Math.hypot(out, across) || 1;
      const faces = (out * this.ahead + across * this.beside) / size;
      if (faces <= 0) return;
      const rise = (/** @type {number} */ place) => high * (1 + sheer * Math.max(place - 0.3, 0));
      const corners = [
        this.point(along, side, low),
        this.point(next, beyond, low),
        this.point(next, beyond, rise(next)),
        this.point(along, side, rise(along)),
      ];
      this.fill(corners, colour, 0.55 + 0.45 * faces);
    });
  }

  /** @param {[number, number, number]} mast along her, from and to [m] */
  mast([along, low, high]) {
    const [x1, y1] = this.point(along, 0, low);
    const [x2, y2] = this.point(along, 0, high);
    const { pen } = this.canvas;
    pen.strokeStyle = this.tint("#5a5a55", 0.8);
    pen.lineWidth = Math.max(0.7, this.scale * 0.5 * Math.abs(this.canvas.x(1) - this.canvas.x(0)));
    pen.beginPath();
    pen.moveTo(x1, y1);
    pen.lineTo(x2, y2);
    pen.stroke();
  }

  sails() {
    const main = [this.point(0.1, 0, 17.4), this.point(0.1, 0, 2.6), this.point(-0.82, 0, 2.6)];
    const jib = [this.point(0.14, 0, 15.6), this.point(0.98, 0, 1.9), this.point(0.2, 0, 2.2)];
    for (const sail of [main, jib]) this.fill(sail, "#f2efe4", 0.75 + 0.25 * Math.abs(this.beside));
  }

  /** @param {number[][]} corners @param {string} colour @param {number} light */
  fill(corners, colour, light) {
    const { pen } = this.canvas;
    pen.fillStyle = this.tint(colour, light);
    pen.beginPath();
    corners.forEach(([x, y], at) => (at ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    pen.closePath();
    pen.fill();
  }

  /** Returns a colour in this light, at her distance. @param {string} colour @param {number} light */
  tint(colour, light) {
    const [own, air] = [colour, this.canvas.haze].map(parts);
    const mixed = own.map((part, at) => {
      const lit = part * light * this.canvas.light;
      return Math.round(lit + (air[at] - lit) * this.haze);
    });
    return `rgb(${mixed.join()})`;
  }
}

/** Returns red, green and blue of a colour. @param {string} colour such as #8090a0 */
export function parts(colour) {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}
