// The boat as it is drawn: in metres, x forward and y down from the middle of its axis.
import { svg } from "../draw.js";

export const LENGTH = 70; // [m] of the hull that the shapes below have
export const KEEL = 4.8; // [m] of it below its axis

const HULL =
  "M-35 0C-30 -2.3 -21 -4.8 -9 -4.8H18C28 -4.8 35 -2.9 35 0C35 2.9 28 4.8 18 4.8H-9C-21 4.8 -30 2.3 -35 0Z";
const CASING = "M-19 -3.6C-16 -5.2 -14 -5.6 -11 -5.7H20C25 -5.6 28 -4.8 31 -3Z";
const SAIL = "M2 -5L4.1 -10.6Q4.4 -11.3 5.2 -11.3H13.2Q14.6 -11.2 15.1 -10L17.4 -5Z";
const FIN = "M-33 -.8L-31.2 -6.8H-27.6L-26 -2.9Z"; // the upper one; the lower is its image
const PLANE = "M2.3 0Q2.3 -.62 .9 -.58L-2.7 -.1V.1L.9 .58Q2.3 .62 2.3 0Z"; // nose to the right
const CONE = "M-34.4 -1L-36.6 -.35V.35L-34.4 1Z";
const BLADES = 7;
const PROPELLER = { at: -35.7, radius: 2.7, rake: 0.9 }; // [m]
const TURNS = 0.09; // a second and a knot: what BB2's propeller turns
const FASTEST = 2.4; // [1/s] a propeller that turns faster would seem to stand

/** The boat from the side, with planes that turn and a propeller. */
export class Hull {
  /** @param {string} shade the id of the gradient that fills it */
  constructor(shade) {
    const fill = `url(#${shade})`;
    this.propeller = svg("path", { class: "blades" });
    this.bow = svg("path", { d: PLANE, class: "plane" });
    this.stern = svg("path", { d: PLANE, class: "plane" });
    this.element = svg(
      "g",
      { class: "hull" },
      this.propeller,
      svg("path", { d: CONE, class: "dark" }),
      svg("path", { d: FIN, class: "dark" }),
      svg("path", { d: FIN, class: "dark", transform: "scale(1 -1)" }),
      svg("path", { d: CASING, class: "dark" }),
      svg("path", { d: SAIL, class: "dark" }),
      svg("path", { d: HULL, fill }),
      svg("path", { d: "M-29 1.9C-22 3.3 -14 3.9 -8 3.9H18C25 3.9 30 3 33 1.9", class: "seam" }),
      svg("path", { d: "M13.4 -9.9h1", class: "window" }),
      svg("g", { transform: "translate(9.6 -8.3)" }, this.bow),
      svg("g", { transform: "translate(-29.4 0) scale(1.25)" }, this.stern),
    );
    this.phase = 0; // [rad] of the propeller
  }

  /**
   * Turns the planes. Rise is positive: the nose of the bow planes goes up, that of the stern
   * planes down.
   * @param {number | null} stern [deg]
   * @param {number | null} bow [deg]
   */
  turnPlanes(stern, bow) {
    this.stern.toggleAttribute("hidden", stern === null);
    this.bow.toggleAttribute("hidden", bow === null);
    this.stern.setAttribute("transform", `rotate(${(stern ?? 0).toFixed(1)})`);
    this.bow.setAttribute("transform", `rotate(${(-(bow ?? 0)).toFixed(1)})`);
  }

  /**
   * Turns the propeller on.
   * @param {number} speed [kn]
   * @param {number} passed [s]
   */
  turnPropeller(speed, passed) {
    const turns = Math.min(Math.max(speed * TURNS, -FASTEST), FASTEST);
    this.phase = (this.phase + 2 * Math.PI * turns * passed) % (2 * Math.PI);
    const { at, radius, rake } = PROPELLER;
    let path = "";
    for (let blade = 0; blade < BLADES; blade += 1) {
      const angle = this.phase + (2 * Math.PI * blade) / BLADES;
      const [across, along] = [radius * Math.sin(angle), rake * Math.cos(angle)];
      path += `M${at} 0Q${(at - along).toFixed(2)} ${(0.6 * across).toFixed(2)}`;
      path += ` ${(at + along * 0.4).toFixed(2)} ${across.toFixed(2)}`;
    }
    this.propeller.setAttribute("d", path);
  }
}
