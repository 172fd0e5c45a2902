// Words in the visitor's language. The English words themselves are the keys of the catalogues,
// which the server has put into the page.
import { one, write } from "./draw.js";

const FIRST = "en";
/** @type {Record<string, Record<string, string>>} */
const CATALOGUES = JSON.parse(one("#words").textContent ?? "{}");
const LANGUAGES = [FIRST, ...Object.keys(CATALOGUES)];

let language = FIRST;

/** Tells `change` when another language is spoken. */
export const changes = new EventTarget();

/** The language that is spoken, such as `de`. */
export function spoken() {
  return language;
}

/**
 * Returns words in the language spoken, with values where `{0}`, `{1}` stand.
 * @param {string} words in English
 * @param {...(string | number)} values
 */
export function say(words, ...values) {
  return translate(language, words).replace(/\{(\d)\}/g, (_, place) => String(values[place]));
}

/** @param {string} into a language @param {string} words */
function translate(into, words) {
  return CATALOGUES[into]?.[words] ?? words;
}

/** Returns a number as the language writes it. @param {number} value */
export function figure(value) {
  return new Intl.NumberFormat(language, { maximumFractionDigits: 0 }).format(value);
}

/** Speaks a language from now on, the first where it is not known. @param {string | null} wanted */
export function speak(wanted) {
  language = LANGUAGES.find((each) => each === wanted) ?? FIRST;
  document.documentElement.lang = language;
  for (const node of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-say]"))) {
    node.dataset.say ||= node.textContent?.trim();
    write(node, say(node.dataset.say ?? ""));
  }
  changes.dispatchEvent(new Event("change"));
}

/** Returns the language after this one, and its own name of itself. */
export function following() {
  const next = LANGUAGES[(LANGUAGES.indexOf(language) + 1) % LANGUAGES.length];
  return { code: next, name: translate(next, "English") };
}
