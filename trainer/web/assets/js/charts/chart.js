// What charts on a canvas share: their size, their pen, their colours, their words.
import { html } from "../draw.js";
import { decimals, say } from "../words.js";

/**
 * @typedef {{ pen: CanvasRenderingContext2D, width: number, height: number, size: number,
 *   colour: (name: string) => string, face: string }} Area where a chart draws, in CSS pixels
 */

const SMALLEST = 4; // [px] of a side that is worth drawing on

/** A canvas that fills its element, sharp at every size, drawn anew when size or palette change. */
export class Chart extends HTMLElement {
  clears = true; // before it is drawn anew
  finest = Infinity; // [px] of the longer side: a larger picture is drawn so fine, and stretched

  connectedCallback() {
    if (this.canvas) return;
    this.setAttribute("role", "img");
    this.setAttribute("aria-label", this.getAttribute("label") ?? say("Chart"));
    this.canvas = /** @type {HTMLCanvasElement} */ (html("canvas", { "aria-hidden": "true" }));
    this.append(this.canvas);
    new ResizeObserver(() => this.draw()).observe(this);
    addEventListener("palette", () => this.draw());
  }

  /** Draws what was shown last. Each chart has its own. */
  draw() {}

  /** Clears the canvas; returns where to draw, null where there is no room. @returns {Area | null} */
  begin() {
    const { canvas } = this;
    const pen = canvas?.getContext("2d");
    const { width, height } = this.getBoundingClientRect();
    if (!canvas || !pen || width < SMALLEST || height < SMALLEST) return null;
    const ratio = Math.min(devicePixelRatio, this.finest / Math.max(width, height));
    const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
    const style = getComputedStyle(this);
    const size = Math.max(11, parseFloat(style.fontSize) * 0.78);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (this.clears) pen.clearRect(0, 0, width, height);
    pen.font = `400 ${size}px ${style.fontFamily}`;
    pen.textBaseline = "middle";
    const colour = (/** @type {string} */ name) => style.getPropertyValue(`--${name}`).trim();
    return { pen, width, height, size, colour, face: style.fontFamily };
  }
}

/** Draws a straight line. @param {CanvasRenderingContext2D} pen @param {number[]} ends x, y, x, y */
export function stroke(pen, [x1, y1, x2, y2]) {
  pen.beginPath();
  pen.moveTo(x1, y1);
  pen.lineTo(x2, y2);
  pen.stroke();
}

/** Returns a number with a true minus sign. @param {number} value @param {number} digits */
export function signed(value, digits) {
  const size = decimals(Math.abs(value), digits);
  return value < 0 && Number(Math.abs(value).toFixed(digits)) !== 0 ? `\u2212${size}` : size;
}

/**
 * Returns the first of some steps that is at least so long on the screen, else the last.
 * @param {number[]} steps
 * @param {number} scale [px] of one
 * @param {number} least [px]
 */
export function stepOf(steps, scale, least) {
  return steps.find((step) => step * scale >= least) ?? steps[steps.length - 1];
}
