// The order grammar, from the table of orders: a line of words to one order.

/**
 * @typedef {{ says: string, units: { text: string, names: string[], factor: number }[], low: number,
 *   high: number, decimals: number, prefix: string }} Measure
 * @typedef {{ spellings?: [string, string][], measure?: Measure, unit?: Measure, name?: string,
 *   course?: boolean }} Place
 * @typedef {{ pattern: string, name: string, value: number, refusal: string }} Form
 * @typedef {{ forms: Form[], sets: Record<string, string>, numbers: Record<string, Measure>,
 *   names: Record<string, string>, signs: Record<string, number> }} Table
 * @typedef {{ spelling: string, word: string }} Said
 * @typedef {{ form: Form, places: Place[], said: Said[] }} Reading
 * @typedef {{ name: string, value: number, word: string, words: string, numbers: number[],
 *   text: string, subject: string }} Order `words` is the text without its numbers and names
 */

const DECIMAL = /^[+-]?(?:[0-9]{1,9}(?:\.[0-9]*)?|\.[0-9]+)$/;
const NAME = /^[a-z][a-z0-9-]*$/;
const GLUED = /^([+-]?[0-9.]+)([a-z][a-z/]*)$/;
const REMARK = /^\s*(mark)\s+(\S.*?)\s*$/i;
const IN_TWO = /\b(one|two)\s+third/gi;
const LONGEST = 80;

/** Why a line is no order. */
export class NoOrder extends Error {}

export class Grammar {
  /** @param {Table} table */
  constructor(table) {
    this.table = table;
    /** @type {Reading[]} */
    this.readings = table.forms.flatMap((form) =>
      this.variants(form.pattern).map((places) => ({ form, places, said: [] })),
    );
  }

  /** Returns the order on a line; throws NoOrder. @param {string} line @returns {Order} */
  parse(line) {
    if (line.length > LONGEST) throw new NoOrder(`line of ${line.length} characters; the longest is ${LONGEST}`);
    const remark = REMARK.exec(line);
    if (remark) return orderOf("mark", { text: `mark ${remark[2]}`, subject: remark[2] });
    const words = line.replace(IN_TWO, "$1-third").toLowerCase().trim().split(/\s+/);
    const tokens = words.flatMap((word) => GLUED.exec(word)?.slice(1) ?? [word]);
    return this.order(this.read(tokens));
  }

  /** @param {string} text of a place @returns {Place} */
  place(text) {
    const { numbers, names, sets } = this.table;
    if (text in numbers) return { measure: numbers[text], course: text === "COURSE" };
    if (text in names) return { name: names[text] };
    if (text === "TOKEN" || text === "TOPIC") return { name: "a word" };
    return { spellings: spellings(sets[text] ?? text) };
  }

  /** Returns every row of places that a pattern allows. @param {string} pattern @returns {Place[][]} */
  variants(pattern) {
    /** @type {Place[][]} */
    let rows = [[]];
    for (const text of pattern.split(" ")) {
      const item = this.place(text.replace(/[[\]]/g, ""));
      const optional = text.startsWith("[");
      const unit = item.measure?.units[0].names.length ? [{ unit: item.measure }] : null;
      rows = rows.flatMap((row) => [
        [...row, item],
        ...(optional ? [row] : []),
        ...(unit ? [[...row, item, ...unit]] : []),
      ]);
    }
    return rows;
  }

  /** Returns the one reading of the tokens. @param {string[]} tokens @returns {Reading} */
  read(tokens) {
    let alive = this.readings;
    tokens.forEach((token, at) => {
      const before = tokens.slice(0, at).join(" ");
      alive = alive.flatMap(({ form, places, said }) =>
        places.length > at ? match(places[at], token).map((each) => ({ form, places, said: [...said, each] })) : [],
      );
      const whole = alive.filter(({ said, places }) => !places[at].spellings || said[at].spelling === token);
      if (alive.some(({ said, places }) => places[at].spellings && said[at].spelling === token)) alive = whole;
      if (!alive.length) throw new NoOrder(before ? `"${token}" after "${before}"` : `"${token}" is no order`);
    });
    tokens.forEach((token, at) => {
      const meant = new Set(alive.map(({ said }) => said[at].word));
      if (meant.size > 1) throw new NoOrder(`"${token}" may be ${[...meant].sort().join(" or ")}`);
    });
    const found = alive.find(({ places }) => places.length === tokens.length);
    if (!found) throw new NoOrder(`${tokens.join(" ")} what?`);
    if (found.form.refusal) throw new NoOrder(found.form.refusal);
    return found;
  }

  /** @param {Reading} reading @returns {Order} */
  order({ form, places, said }) {
    const head = headOf(form.pattern);
    const optional = form.pattern.split(" ").slice(1).filter((each) => each.startsWith("["));
    const left = optional.map((each) => each.replace(/[[\]]/g, ""));
    const { signs } = this.table;
    let [sign, subject] = [1, ""];
    const [text, rest, words, wordings] = [[head, ...left], [""], [""], [""]].map((each) => each.filter(Boolean));
    /** @type {number[]} */
    const numbers = [];
    places.forEach((place, at) => {
      const { word } = said[at];
      if (place.measure) {
        const [value, wording] = quantity(place, word, said[at + 1]?.word);
        numbers.push(value);
        wordings.push(wording);
      } else if (place.name) wordings.push((subject = word));
      else if (place.unit || (at ? left : [head]).includes(word)) return;
      else if (word in signs && head !== "order") {
        sign = signs[word];
        text.push(word);
      } else {
        words.push(word);
        rest.push(word);
      }
    });
    const value = sign * (numbers.at(-1) ?? form.value) + 0;
    const keyed = [...text, ...rest].join(" ");
    const word = words.join("_").replaceAll("-", "_");
    const whole = [keyed, ...wordings].join(" ");
    return orderOf(form.name || head, { value, word, words: keyed, numbers, text: whole, subject });
  }
}

/** @param {string} name @param {Partial<Order>} parts @returns {Order} */
function orderOf(name, parts) {
  return { name, value: 0, word: "", words: name, numbers: [], text: name, subject: "", ...parts };
}

/** Returns each spelling in `a=b|c` with the word it stands for. @param {string} text @returns {[string, string][]} */
function spellings(text) {
  return text.split("|").flatMap((each) => {
    const names = each.split("=");
    return names.map((name) => /** @type {[string, string]} */ ([name, names[0]]));
  });
}

/** Returns the word that heads a form. @param {string} pattern */
function headOf(pattern) {
  const first = pattern.split(" ")[0].replace(/[[\]]/g, "");
  return first === "BOW" ? "bow" : spellings(first)[0][1];
}

/** Returns the ways a token fits a place. @param {Place} place @param {string} token @returns {Said[]} */
function match(place, token) {
  const same = [{ spelling: token, word: token }];
  if (place.measure) {
    const { prefix } = place.measure;
    const digits = prefix && token.startsWith(prefix) ? token.slice(prefix.length) : token;
    return DECIMAL.test(digits) ? [{ spelling: token, word: digits }] : [];
  }
  if (place.name) return NAME.test(token) ? same : [];
  if (place.unit) return place.unit.units.some(({ names }) => names.includes(token)) ? same : [];
  const whole = !/^[a-z]/.test(token);
  return (place.spellings ?? [])
    .filter(([spelling]) => (whole ? spelling === token : spelling.startsWith(token)))
    .map(([spelling, word]) => ({ spelling, word }));
}

/** Returns the number [SI] and its wording. @param {Place} place @param {string} digits @param {string} [said] @returns {[number, string]} */
function quantity(place, digits, said) {
  const measure = /** @type {Measure} */ (place.measure);
  const unit = measure.units.find(({ names }) => said && names.includes(said)) ?? measure.units[0];
  const [size, value] = [measure.units[0].factor, Number(digits) * unit.factor];
  const limits = `${measure.low} to ${measure.high} ${measure.units[0].names[0] ?? ""}`.trim();
  if (/^[+-]/.test(digits) && measure.low >= 0) throw new NoOrder(`"${digits}": ${measure.says} takes no sign`);
  if (measure.decimals === 0 && digits.includes(".")) throw new NoOrder(`"${digits}": ${measure.says} has no decimals`);
  if (!(measure.low * size <= value && value <= measure.high * size)) {
    throw new NoOrder(`${`${digits} ${unit.text}`.trim()}: ${measure.says} is ${limits}`);
  }
  if (place.course) {
    const course = Number(digits) === 360 ? 0 : Number(digits);
    return [course * unit.factor, String(course).padStart(3, "0")];
  }
  return [value, `${Number(digits)} ${unit.text}`.trim()];
}
