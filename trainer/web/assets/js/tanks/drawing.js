// The picture of the tanks as SVG. Parts that change bear a name in `data-part`.
import { svg } from "../draw.js";
import { BANKS, BLOWN, MAIN, TITLES } from "./places.js";
import { say } from "../words.js";

/**
 * @typedef {import("./places.js").Form} Form
 * @typedef {import("../draw.js").Attributes} Attributes
 */

const BETWEEN = 198; // of the short form: where a word lies between two pipes

/**
 * Returns the whole picture.
 * @param {Form} form
 * @param {(tank: string) => Attributes} keys what makes a tank a key
 */
export function drawTanks(form, keys) {
  const [width, height] = form.size;
  const [x, y, w, h] = form.inner;
  const none = { class: "none", "data-part": "none", hidden: true };
  return svg(
    "svg",
    { viewBox: `0 0 ${width} ${height}`, role: "group", "aria-label": say("Tanks") },
    hatch(),
    svg("path", { d: form.hull, class: "boat" }),
    svg("rect", { x, y, width: w, height: h, rx: h / 6, class: "inner" }),
    ...Object.keys(form.dry).map((name) => drawDry(name, form)),
    svg("path", { d: header(form), class: "pipe", "data-part": "header" }),
    ...Object.keys(BANKS).map((name) => drawBank(name, form)),
    drawTrim(form),
    ...Object.keys(TITLES).map((name) => drawTank(name, form, keys(name))),
    ...Object.keys(TITLES).map((name) => drawWords(name, form)),
    label(say("This boat has no tanks"), { ...none, x: width / 2, y: height / 2 }),
    svg("path", { d: cross(width, height), class: "cross" }),
  );
}

/** @param {string} words @param {Attributes} attributes */
function label(words, attributes) {
  const text = svg("text", attributes);
  text.textContent = words;
  return text;
}

/** @param {string} name @param {Form} form @param {Attributes} keys */
function drawTank(name, form, keys) {
  const [x, y, width, height] = form.tanks[name];
  const [title] = TITLES[name];
  const key = { class: "tank", role: "button", tabindex: 0, "aria-label": title };
  return svg(
    "g",
    { ...key, "data-part": name, ...keys },
    svg("rect", { x: x - 4, y: y - 4, width: width + 8, height: height + 28, class: "reach" }),
    svg("rect", { x, y, width, height, class: "well" }),
    svg("rect", { x, y, width, height: 0, class: "water", "data-part": `${name} level` }),
    svg("path", { class: "target", "data-part": `${name} target` }),
    svg("rect", { x, y, width, height, class: "rim" }),
  );
}

/** Draws what is written and fitted at a tank: its key says it in words. */
function drawWords(/** @type {string} */ name, /** @type {Form} */ form) {
  const [x, y, width, height] = form.tanks[name];
  const main = MAIN.includes(name);
  const [middle, half] = [x + width / 2, y + height / 2];
  const pad = 5;
  const side = main && form.short; // beside one another: a name in full goes above
  const titled = side
    ? { x: x + pad, y: half, class: "name start" }
    : { x: middle, y: main ? y + 0.28 * height : y + height + form.names, class: "name" };
  const worth = side
    ? { x: x + width - pad, y: half, class: "value end" }
    : { x: middle, y: main ? y + 0.72 * height : half, class: "value tight" };
  return svg(
    "g",
    { class: "words", "aria-hidden": "true", "data-part": `${name} words` },
    BLOWN.includes(name) && drawAir(name, form),
    !main && !name.startsWith("trim") && drawSea(name, form),
    label(TITLES[name][form.short ? 1 : 0], titled),
    svg("text", { ...worth, "data-part": `${name} value` }),
    svg("path", { class: "flow", "data-part": `${name} flow` }),
  );
}

/** Draws vent and blow valve on a tank, and their pipes. @param {string} name @param {Form} form */
function drawAir(name, form) {
  const [x, y, width] = form.tanks[name];
  const inside = !MAIN.includes(name);
  const vent = x + width * (inside ? 0.78 : 0.2);
  const blow = x + width * (inside ? 0.27 : 0.8);
  const open = form.header + (form.short ? 6 : 12);
  const height = y - (form.short ? 6 : 10);
  const top = inside ? height - (form.short ? 0 : 2) : open;
  return svg(
    "g",
    { class: "air" },
    svg("path", { d: `M${vent} ${y}V${top}m-5 0h10`, class: "pipe" }),
    svg("path", { d: `M${blow} ${y}V${form.header}`, class: "pipe", "data-part": `${name} air` }),
    drawValve(`vent_${name}`, vent, inside ? height : form.valves, form),
    drawValve(`blow_${name}`, blow, form.valves, form),
  );
}

/** Draws the way to the sea: a pump, or a valve. @param {string} name @param {Form} form */
function drawSea(name, form) {
  const [x, y, width, height] = form.tanks[name];
  const middle = x + width / 2;
  const start = y + height + form.names + (form.short ? 7 : 9);
  return svg(
    "g",
    {},
    svg("path", { d: `M${middle} ${start}V${form.keel}`, class: "pipe" }),
    name === "negative"
      ? drawValve("negative_flood", middle, form.trim, form, 15) // not on the trim pipe
      : svg("circle", { cx: middle, cy: form.trim, r: form.short ? 7 : 11, class: "pump" }),
  );
}

/** @param {Form} form */
function drawTrim(form) {
  const [aft, fore] = [form.tanks.trim_aft, form.tanks.trim_forward];
  const [left, right] = [aft[0] + aft[2] / 2, fore[0] + fore[2] / 2];
  const start = aft[1] + aft[3] + form.names + (form.short ? 7 : 9);
  const radius = form.short ? 7 : 11;
  return svg(
    "g",
    { "data-part": "trim" },
    svg("path", { d: `M${left} ${start}V${form.trim}H${right}V${start}`, class: "pipe" }),
    svg("circle", { cx: left + 4 * radius, cy: form.trim, r: radius, class: "pump" }),
    svg("path", { class: "flow", "data-part": "trim flow" }),
  );
}

/**
 * @param {string} name
 * @param {number} x
 * @param {number} y
 * @param {Form} form
 * @param {number} [below] how far below the valve its word stands
 */
function drawValve(name, x, y, form, below = 0) {
  const place = `translate(${x} ${y}) scale(${form.short ? 0.75 : 1})`;
  return svg(
    "g",
    { class: "valve" },
    svg(
      "g",
      { transform: place, "data-part": name },
      svg("path", { d: "M-8 -10H8L-8 10H8Z", class: "body" }),
      svg("path", { d: "M-11 0H11", class: "lever" }),
    ),
    !form.short && svg("text", { x: x + 15, y: y + below, class: "word", "data-part": `${name} word` }),
  );
}

/** @param {string} name @param {Form} form */
function drawBank(name, form) {
  const [x, y, width, height] = form.banks[name];
  const half = y + height / 2;
  const worth = { x: x + width + 6, y: half, class: "value start" };
  return svg(
    "g",
    { class: "bank", "data-part": `bank ${name}` },
    svg("path", { d: `M${x + width / 2} ${y + height}V${form.header}`, class: "pipe" }),
    svg("rect", { x, y, width, height, class: "well" }),
    svg("rect", { x, y, width: 0, height, class: "full", "data-part": `bank ${name} level` }),
    svg("rect", { x, y, width, height, class: "rim" }),
    label(BANKS[name][form.short ? 1 : 0], { x: x - 6, y: half, class: "name end" }),
    svg("text", { ...worth, "data-part": `bank ${name} value` }),
  );
}

/** Draws a compartment where no water belongs; a short form has its word below the boat. */
function drawDry(/** @type {string} */ name, /** @type {Form} */ form) {
  const [x, y, width, height] = form.dry[name];
  const place = form.short ? Object.keys(form.dry).indexOf(name) : 1;
  const word = {
    x: form.short && place === 1 ? BETWEEN : x + (width * place) / 2,
    y: form.short ? form.size[1] - 6 : y + 9,
    class: `word ${["start", "middle", "end"][place]}`,
  };
  return svg(
    "g",
    { class: "flooded", "data-part": name, hidden: true },
    svg("rect", { x, y, width, height, fill: "url(#flooded)" }),
    svg("text", { ...word, "data-part": `${name} word` }),
  );
}

/** Returns the pattern of a flooded compartment. */
function hatch() {
  const size = { id: "flooded", width: 8, height: 8, patternUnits: "userSpaceOnUse" };
  return svg("defs", {}, svg("pattern", size, svg("path", { d: "M0 8L8 0", class: "hatch" })));
}

/** Returns the air pipe above the tanks. @param {Form} form */
function header(form) {
  const [aft, , wide] = form.tanks.aft;
  const [fore, , far] = form.tanks.forward;
  const bank = form.banks.main[0] + form.banks.main[2] / 2;
  return `M${Math.min(aft + wide * 0.8, bank)} ${form.header}H${fore + far * 0.8}`;
}

/** Returns the cross over an instrument that is not to be believed. */
function cross(/** @type {number} */ width, /** @type {number} */ height) {
  const [left, top, right, foot] = [width * 0.2, height * 0.2, width * 0.8, height * 0.8];
  return `M${left} ${top}L${right} ${foot}M${right} ${top}L${left} ${foot}`;
}

/**
 * Returns a chevron, upwards where water flows in.
 * @param {number} x
 * @param {number} y
 * @param {number} size
 * @param {number} flow
 */
export function chevron(x, y, size, flow) {
  return `M${x - size} ${y + (size * flow) / 2}l${size} ${-size * flow}l${size} ${size * flow}`;
}

/**
 * Returns a chevron along a pipe, to the right where water flows forward.
 * @param {number} x
 * @param {number} y
 * @param {number} size
 * @param {number} flow
 */
export function sideways(x, y, size, flow) {
  return `M${x - (size * flow) / 2} ${y - size}l${size * flow} ${size}l${-size * flow} ${size}`;
}
