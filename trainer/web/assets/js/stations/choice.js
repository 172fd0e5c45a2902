// The first page: which station is this browser to be?
import { Link } from "../protocol/link.js";
import { one, write } from "../draw.js";

const link = new Link(document.documentElement.dataset.version ?? "");
const state = one("#state");

link.addEventListener("open", () => void lookRound());
link.addEventListener("lost", () => {
  state.dataset.state = "lost";
  write(state, `NO LINK: ${link.why}`);
});
link.open();

/** Shows who is aboard, where the session tells it without a token. */
async function lookRound() {
  link.settle();
  state.dataset.state = "running";
  write(state, "CONNECTED");
  const who = await link.order("who");
  for (const key of document.querySelectorAll("[data-role]")) {
    const role = /** @type {HTMLElement} */ (key).dataset.role ?? "";
    const aboard = who.lines.filter((line) => line.startsWith(`${role} at `)).length;
    write(one("small", key), aboard ? `${aboard} aboard` : "free");
  }
}
