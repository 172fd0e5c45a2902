// What a station says to the instructor: a report in its own words, or one of the usual ones.
import { html } from "../draw.js";

const USUAL = ["on course", "on depth", "steady", "no answer from the planes", "no answer from the rudder"];

/** @typedef {import("../model/session.js").Session} Session */

/** `<report-bar data-control>` with `bind(session)`. */
class ReportBar extends HTMLElement {
  /** @param {Session} session */
  bind(session) {
    if (session.alone) return; // nobody would hear it
    const field = /** @type {HTMLInputElement} */ (
      html("input", { list: "reports", placeholder: "report", "aria-label": "Report", maxlength: 60 })
    );
    const choices = USUAL.map((words) => html("option", { value: words }));
    const form = html(
      "form",
      { class: "row" },
      field,
      html("datalist", { id: "reports" }, ...choices),
      html("button", {}, "Report"),
    );
    form.onsubmit = (event) => {
      event.preventDefault();
      if (field.value.trim()) void session.order(`report ${field.value.trim()}`);
      field.value = "";
    };
    this.replaceChildren(form);
  }
}

customElements.define("report-bar", ReportBar);
