// One scale for a dial and its lever: values lie evenly along a chord, and on the arc over it.
import { clamp } from "./gauge.js";

/** @typedef {import("./gauge.js").Point} Point */

const BAND = 2.9; // of the text's size: ticks and numerals, inside the arc
const BUG = 1.4; // of the text's size: what is ordered, outside the arc of a dial without a lever
const RIM = 8; // [px] between the arc and a lever below it
const CORNER = 50; // [px] that a lever's ends lie above its middle, so that keys have the corners
const STEEP = 0.8; // sagitta of an arc by half its chord, at most
const FLAT = 0.4; // the same where a lever lies on it
const POINTS = 24; // of a drawn arc

/** Where the values of an instrument stand in its box; shares go from -1 to 1 along the chord. */
export class Fan {
  /**
   * @param {string} face where the middle of the arc looks: `down`, `left`, `right`
   * @param {[number, number]} box width and height [px]
   * @param {number} text size of numerals [px]
   * @param {[number, number]} [knob] width and height of the lever's knob [px], where it has one
   */
  constructor(face, [width, height], text, knob) {
    const down = face === "down";
    this.face = face;
    this.text = text;
    this.box = [width, height];
    const [long, deep] = down ? [width, height] : [height, width];
    const [along, across] = down ? (knob ?? [0, 0]) : [knob?.[1] ?? 0, knob?.[0] ?? 0];
    this.half = Math.max(long / 2 - Math.max(along / 2 + 1, 1.3 * text), 1);
    const steep = (knob ? FLAT : STEEP) * this.half;
    const band = BAND * text;
    if (down) {
      this.middle = deep - (knob ? across + RIM : BUG * text);
      const least = knob ? Math.min(CORNER, this.middle) : 0;
      this.sag = Math.max(Math.min(this.middle - band, steep), least);
      this.rail = this.middle + RIM + across / 2;
      this.inner = [0, this.middle - band];
    } else {
      const edge = knob ? across + band : band;
      this.sag = clamp(deep - edge - (knob ? 3 : BUG * text), 0, steep);
      const spare = knob ? 0 : Math.max(deep - edge - this.sag - BUG * text, 0) / 2;
      this.middle = spare + edge + this.sag;
      this.rail = across / 2;
      this.inner = knob ? [this.middle + text, deep] : [spare, this.middle - band];
    }
    this.chord = Boolean(knob) && !down; // along which the lever lies, its digits outside the arc
    this.radius = this.sag > 0.5 ? (this.half ** 2 + this.sag ** 2) / (2 * this.sag) : Infinity;
  }

  /** Returns a place of the box. @param {number} along from the middle @param {number} across from the inner edge @returns {Point} */
  place(along, across) {
    const [width, height] = this.box;
    if (this.face === "down") return [width / 2 + along, across];
    return [this.face === "right" ? across : width - across, height / 2 - along];
  }

  /** Returns where the room inside the arc's numerals ends. @param {number} along from the middle */
  within(along) {
    return this.middle - BAND * this.text - this.fall(Math.min(along, this.half));
  }

  /** Returns how far the arc falls behind its middle. @param {number} along */
  fall(along) {
    const { radius } = this;
    return radius === Infinity ? 0 : radius - Math.sqrt(Math.max(radius ** 2 - along ** 2, 0));
  }

  /** Returns a place on the arc, or so far inside it. @param {number} share @param {number} [inside] [px] */
  point(share, inside = 0) {
    const along = share * this.half;
    const lean = along / this.radius; // the sine of the normal's angle
    const upright = Math.sqrt(1 - Math.min(lean ** 2, 1));
    return this.place(along - inside * lean, this.middle - this.fall(along) - inside * upright);
  }

  /** Returns where the middle of the lever's knob is. @param {number} share */
  knob(share) {
    const along = share * this.half;
    return this.place(along, this.rail - (this.face === "down" ? this.fall(along) : 0));
  }

  /** Returns what brings a part that points up to the arc, pointing outward. @param {number} share */
  stand(share) {
    const [[x, y], [inX, inY]] = [this.point(share), this.point(share, 1)];
    const angle = (Math.atan2(x - inX, inY - y) * 180) / Math.PI;
    return `translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${angle.toFixed(1)})`;
  }

  /** Returns a path along the scale. @param {number} from share @param {number} to share @param {(share: number) => Point} place */
  path(from, to, place) {
    const shares = Array.from({ length: POINTS + 1 }, (_, at) => from + ((to - from) * at) / POINTS);
    return `M${shares.map((share) => place(share).map((each) => each.toFixed(1)).join(" ")).join("L")}`;
  }

  /** Returns the share of a place on the page. @param {{ clientX: number, clientY: number }} event @param {DOMRect} box */
  share({ clientX, clientY }, box) {
    const [x, y] = [clientX - box.left, clientY - box.top];
    return this.face === "down" ? (x - this.box[0] / 2) / this.half : (this.box[1] / 2 - y) / this.half;
  }
}
