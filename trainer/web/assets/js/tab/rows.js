// Orders that are nothing but numbers written into the state: rows of WORDS;LOW;HIGH;FACTOR;TURN;WRITES.

/**
 * @typedef {{ words: string, low: number, high: number, factor: number, number: boolean,
 *   writes: { place: number, rule: string, argument: number }[] }} Row
 */

/** Returns the rows by their words. @param {string[]} texts @returns {Map<string, Row>} */
export function rowsOf(texts) {
  return new Map(texts.map(rowOf).map((row) => [row.words, row]));
}

/** @param {string} text @returns {Row} */
function rowOf(text) {
  const [words, low, high, factor, , writes] = text.split(";");
  const parsed = writes.split(",").map((write) => {
    const [place, rule, argument] = write.split(/[=:]/);
    return { place: Number(place), rule, argument: Number(argument) };
  });
  const [least, most, size] = [low, high, factor || "1"].map(Number);
  return { words, low: least, high: most, factor: size, number: low !== "", writes: parsed };
}

/**
 * Writes what a row means with a number; returns why not, "" when it is done.
 * @param {Row} row
 * @param {number} x [SI] signed as the words say
 * @param {Float64Array} state
 */
export function carryOut(row, x, state) {
  if (row.number && !(row.low <= x && x <= row.high)) {
    const ends = [row.low, row.high].map((end) => Number((end / row.factor + 0).toPrecision(6)));
    return `this boat takes ${Math.min(...ends)} to ${Math.max(...ends)}`;
  }
  for (const { place, rule, argument } of row.writes) {
    if (rule === "const") state[place] = argument;
    else if (rule === "number") state[place] = argument * x;
    else if (rule === "over") state[place] = x / argument;
    else if (rule === "place") state[place] = state[argument];
    else {
      const near = state[argument];
      state[place] = near + remainder((rule === "short" ? x : state[place]) - near, 2 * Math.PI);
    }
  }
  return "";
}

/** Returns what is left of x beyond the nearest multiple of y, exactly. @param {number} x @param {number} y */
export function remainder(x, y) {
  const left = Math.abs(x % y);
  const odd = Math.abs(x % (2 * y)) >= y;
  const beyond = left > y / 2 || (left === y / 2 && odd);
  const size = beyond ? left - y : left;
  return x < 0 ? -size : size;
}
