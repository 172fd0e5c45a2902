// What a station says to the instructor: a report in its own words, or one of the usual ones.
import { html } from "../draw.js";

const USUAL = ["on course", "on depth", "steady", "no answer from the planes", "no answer from the rudder"];

/** @typedef {import("../model/session.js").Session} Session */

/** `<report-bar data-control>` with `bind(session)`. On a phone it is a key that opens a window. */
class ReportBar extends HTMLElement {
  /** @param {Session} session */
  bind(session) {
    if (session.alone) return; // nobody would hear it
    const close = html("button", { type: "button", click: () => dialog.close() }, "Close");
    const give = (/** @type {string} */ words) => {
      if (!words) return;
      void session.order(`report ${words}`);
      dialog.close();
    };
    const usual = USUAL.map((words) =>
      html("button", { type: "button", click: () => give(words) }, words),
    );
    const says = { class: "reports", "aria-label": "Reports to the instructor" };
    const dialog = /** @type {HTMLDialogElement} */ (html("dialog", says, ...usual, close));
    const form = reportForm(give);
    const open = () => {
      close.before(form);
      dialog.showModal();
    };
    dialog.onclose = () => dialog.before(form);
    session.on("state", () => session.live || dialog.close());
    const key = html("button", { type: "button", class: "open", click: open }, "Report");
    this.replaceChildren(key, form, dialog);
  }
}

/** Returns a field for a report, and its key. @param {(words: string) => void} give */
function reportForm(give) {
  const says = { list: "reports", placeholder: "report", "aria-label": "Report", maxlength: 60 };
  const field = /** @type {HTMLInputElement} */ (html("input", says));
  const choices = USUAL.map((words) => html("option", { value: words }));
  const list = html("datalist", { id: "reports" }, ...choices);
  const form = html("form", { class: "row" }, field, list, html("button", {}, "Report"));
  form.onsubmit = (event) => {
    event.preventDefault();
    give(field.value.trim());
    field.value = "";
  };
  return form;
}

customElements.define("report-bar", ReportBar);
