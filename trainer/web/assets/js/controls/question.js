// A question before something that acts at once.
import { html } from "../draw.js";
import { say } from "../words.js";

/**
 * Asks whether to go on; resolves with the answer.
 * @param {string} title
 * @param {string} says what will happen
 * @param {string} yes words of the key that goes on
 * @returns {Promise<boolean>}
 */
export function ask(title, says, yes) {
  const go = html("button", { value: "yes", class: "yes" }, yes);
  const back = html("button", { value: "no", autofocus: true }, say("No"));
  const form = html("form", { method: "dialog" }, html("h2", { id: "question" }, title));
  form.append(html("p", {}, says), html("p", { class: "row" }, go, back));
  const dialog = /** @type {HTMLDialogElement} */ (
    html("dialog", { "aria-labelledby": "question", class: "question", "data-control": true }, form)
  );
  document.body.append(dialog);
  dialog.showModal();
  return new Promise((settle) => {
    dialog.onclose = () => {
      dialog.remove();
      settle(dialog.returnValue === "yes");
    };
  });
}
