// What may come next in an order, from the table of orders that the page was made with.

/**
 * @typedef {{ forms: [string, string][], numbers: Record<string, string> }} OrderWords
 * @typedef {{ words: string[], hints: string[] }} Next words that may come, and what else may
 * @typedef {Record<string, () => string[]>} Names what a place such as NAME may hold
 */

/**
 * Returns each way to write a form, with and without what may be left out.
 * @param {string} form
 * @returns {string[][]}
 */
function ways(form) {
  /** @type {string[][]} */
  let found = [[]];
  for (const item of form.split(" ")) {
    const word = item.replace(/[[\]]/g, "");
    const longer = found.map((way) => [...way, word]);
    found = item.startsWith("[") ? [...longer, ...found] : longer;
  }
  return found;
}

/** @param {string} place */
function isNumber(place) {
  return /^[A-Z]+$/.test(place);
}

/**
 * Returns what may come next after a text; its last word may be begun.
 * @param {OrderWords} table
 * @param {Names} names
 * @param {string} text
 * @returns {Next}
 */
export function next(table, names, text) {
  const typed = text.toLowerCase().trimStart().split(/\s+/);
  const begun = typed.pop() ?? "";
  const words = new Set();
  const hints = new Set();
  for (const [form, says] of table.forms) {
    for (const way of ways(form)) {
      const place = way[typed.length];
      if (!typed.every((word, at) => fits(way[at], word, names))) continue;
      if (place === undefined) {
        if (!begun) hints.add(says);
      } else {
        for (const word of choices(place, names)) if (word.startsWith(begun)) words.add(word);
        if (isNumber(place) && !names[place]) hints.add(table.numbers[place] ?? place.toLowerCase());
      }
    }
  }
  return { words: [...words], hints: [...hints] };
}

/** Whether a word can stand at a place. @param {string | undefined} place @param {string} word @param {Names} names */
function fits(place, word, names) {
  if (place === undefined) return false;
  if (!isNumber(place)) return place.split("|").some((each) => each.startsWith(word));
  return names[place] ? true : place === "REMARK" || /^[x+-]?[\d.]/.test(word);
}

/** @param {string} place @param {Names} names @returns {string[]} */
function choices(place, names) {
  if (!isNumber(place)) return place.split("|");
  return names[place]?.() ?? [];
}
