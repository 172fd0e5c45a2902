// Words in the language that is chosen. The English words themselves are the keys of the catalogues,
// which the server has put into the page; a word that a catalogue lacks stays English.

const FIRST = "en";
const KEPT = "language"; // where the browser keeps the choice
/** Attributes of the page's HTML that people read or hear: READ_ATTRIBUTES of words.py. */
const READ = [
  ...["aria-label", "placeholder", "title", "label", "low", "high"],
  ...["data-says", "data-short", "data-lower", "data-higher", "word-centre", "word-forward"],
];
const page = globalThis.document; // a worker has none
/** @type {Record<string, Record<string, string>>} */
const CATALOGUES = JSON.parse(page?.querySelector("#words")?.textContent ?? "{}");
const LANGUAGES = [FIRST, ...Object.keys(CATALOGUES)];
/** What the page's HTML says, and where, in English. @type {[{ data: string } | Attr, string][]} */
const written = page ? [...texts(page), ...attributes(page)] : [];

let language = FIRST;
let mark = "."; // between a whole number and its decimals

/** Tells `change` when another language is spoken. */
export const changes = new EventTarget();

/** The language that is spoken, such as `de`. */
export function spoken() {
  return language;
}

/** The languages that there are, and each one's own name of itself. @returns {[string, string][]} */
export function languages() {
  return LANGUAGES.map((each) => [each, translate(each, "English")]);
}

/**
 * Returns words in the language spoken, with values where `{0}`, `{1}` stand.
 * @param {string} words in English
 * @param {...(string | number)} values
 */
export function say(words, ...values) {
  const write = (/** @type {string | number} */ each) => (typeof each === "number" ? short(each) : each);
  return translate(language, words).replace(/\{(\d)\}/g, (_, place) => write(values[place]));
}

/** Returns a number as short as it is known, with the mark that the language writes. @param {number} value */
export function short(value) {
  return String(value).replace(".", mark);
}

/** @param {string} into a language @param {string} words */
function translate(into, words) {
  return CATALOGUES[into]?.[words] ?? words;
}

/** Returns a number as the language writes it. @param {number} value */
export function figure(value) {
  return new Intl.NumberFormat(language, { maximumFractionDigits: 0 }).format(value);
}

/** Returns a number with so many digits after the mark that the language writes. @param {number} value @param {number} digits */
export function decimals(value, digits) {
  return value.toFixed(digits).replace(".", mark);
}

/** Speaks a language from now on, the first where it is not known. @param {string | null} wanted */
export function speak(wanted) {
  language = LANGUAGES.find((each) => each === wanted) ?? FIRST;
  mark = new Intl.NumberFormat(language).format(0.5).charAt(1);
  if (!page) return;
  page.documentElement.lang = language;
  for (const [place, english] of written) {
    const spokenText = english.replace(/\S.*\S|\S/s, (core) => say(core.replace(/\s+/g, " ")));
    if ("data" in place) place.data = spokenText;
    else place.value = spokenText;
  }
  changes.dispatchEvent(new Event("change"));
}

/** Returns the language after this one, and its own name of itself. */
export function following() {
  const next = LANGUAGES[(LANGUAGES.indexOf(language) + 1) % LANGUAGES.length];
  return { code: next, name: translate(next, "English") };
}

/** Keeps a language for this browser. @param {string} wanted */
export function keepLanguage(wanted) {
  localStorage.setItem(KEPT, wanted);
}

/** The language that is asked for or was kept, else the browser's own. */
function chosen() {
  const asked = new URLSearchParams(location.search).get("lang") ?? localStorage.getItem(KEPT);
  const own = navigator.languages.map((each) => each.split("-")[0]);
  return asked ?? own.find((each) => LANGUAGES.includes(each)) ?? FIRST;
}

/** Returns the texts of the page's HTML. @param {Document} from @returns {[Text, string][]} */
function texts(from) {
  const walker = from.createTreeWalker(from.documentElement, NodeFilter.SHOW_TEXT);
  /** @type {[Text, string][]} */
  const found = [];
  while (walker.nextNode()) {
    const node = /** @type {Text} */ (walker.currentNode);
    const told = !["SCRIPT", "STYLE"].includes(node.parentElement?.tagName ?? "");
    if (told && /\p{L}/u.test(node.data)) found.push([node, node.data]);
  }
  return found;
}

/** Returns the attributes of the page's HTML that are read. @param {Document} from @returns {[Attr, string][]} */
function attributes(from) {
  return READ.flatMap((name) =>
    [...from.querySelectorAll(`[${name}]`)].map((each) => {
      const place = /** @type {Attr} */ (each.getAttributeNode(name));
      return /** @type {[Attr, string]} */ ([place, place.value]);
    }),
  );
}

if (page) speak(chosen());
