// What a station says to the instructor: a report in its own words, or one of the usual ones.
import { html, write } from "../draw.js";
import { say } from "../words.js";

/** What is reported most, as the session takes it, and in words. @type {[string, string][]} */
const USUAL = [
  ["on course", say("on course")],
  ["on depth", say("on depth")],
  ["steady", say("steady")],
  ["no answer from the planes", say("no answer from the planes")],
  ["no answer from the rudder", say("no answer from the rudder")],
];

/** @typedef {import("../model/session.js").Session} Session */

/** `<report-bar data-control>` with `bind(session)`. On a phone it is a key that opens a window. */
class ReportBar extends HTMLElement {
  /** @param {Session} session */
  bind(session) {
    if (session.alone) return; // nobody would hear it
    const close = html("button", { type: "button", click: () => dialog.close() }, say("Close"));
    const aloud = html("span", { class: "unseen", role: "status" });
    const give = async (/** @type {string} */ words) => {
      if (!words) return;
      dialog.close();
      write(aloud, (await session.order(`report ${words}`)).text);
    };
    const usual = USUAL.map(([report, words]) =>
      html("button", { type: "button", click: () => void give(report) }, words),
    );
    const says = { class: "reports", "aria-label": say("Reports to the instructor") };
    const dialog = /** @type {HTMLDialogElement} */ (html("dialog", says, ...usual, close));
    const form = reportForm(give);
    const open = () => {
      close.before(form);
      dialog.showModal();
    };
    dialog.onclose = () => dialog.open || dialog.before(form); // it comes late: it may be open anew
    session.on("state", () => session.live || dialog.close());
    const key = html("button", { type: "button", class: "open", click: open }, say("Report"));
    this.replaceChildren(key, form, dialog, aloud);
  }
}

/** Returns a field for a report, and its key. @param {(words: string) => Promise<void>} give */
function reportForm(give) {
  const says = { list: "reports", placeholder: say("report"), "aria-label": say("Report"), maxlength: 60 };
  const field = /** @type {HTMLInputElement} */ (html("input", says));
  const choices = USUAL.map(([value, label]) => html("option", { value, label }));
  const list = html("datalist", { id: "reports" }, ...choices);
  const form = html("form", { class: "row" }, field, list, html("button", {}, say("Report")));
  form.onsubmit = (event) => {
    event.preventDefault();
    void give(field.value.trim());
    field.value = "";
  };
  return form;
}

customElements.define("report-bar", ReportBar);
