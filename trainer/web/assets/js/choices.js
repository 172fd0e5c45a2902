// The choice of language and units, which the browser keeps. The page is loaded anew for it.
import { html, one, write } from "./draw.js";
import { keepUnit, unit } from "./units.js";
import { keepLanguage, languages, say, spoken } from "./words.js";

/** Furnishes the key that opens the choice, and its fields. */
export function furnishChoices() {
  const language = /** @type {HTMLSelectElement} */ (one("#language"));
  const units = /** @type {HTMLSelectElement} */ (one("#units"));
  language.append(...languages().map(([code, name]) => html("option", { value: code, lang: code }, name)));
  [language.value, units.value] = [spoken(), unit];
  const shown = `${spoken().toUpperCase()} ${unit}`;
  write(one("#open-choices"), shown);
  one("#open-choices").setAttribute("aria-label", `${shown}: ${say("Language and units")}`);
  language.onchange = () => loadAnew(() => keepLanguage(language.value));
  units.onchange = () => loadAnew(() => keepUnit(units.value));
}

/** Loads the page with what was chosen, and without what its address has asked for. @param {() => void} keep */
function loadAnew(keep) {
  keep();
  const address = new URL(location.href);
  for (const asked of ["lang", "units"]) address.searchParams.delete(asked);
  if (address.href === location.href) location.reload();
  else location.replace(address);
}
