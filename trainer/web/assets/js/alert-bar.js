// The alerts of a page, by the conduct of IMO MSC.302(87) and A.1021(26): the bell with the count of
// new ones and Silence at the left end, always; then the worst alert in full; all of them in a list.
import { clock, html, svg, write } from "./draw.js";
import { RANKS } from "./model/alerts.js";
import { say } from "./words.js";

/**
 * @typedef {import("./model/alerts.js").Alerts} Alerts
 * @typedef {import("./model/alerts.js").Shown} Shown
 */

const SHAPES = {
  emergency: "M12 1L23.5 22.5H.5Z",
  alarm: "M12 1L23.5 22.5H.5Z",
  warning: "M12 1a11 11 0 1 0 .01 0Z",
  caution: "M2 2H22V22H2Z",
};
const BELL = "M12 2a2 2 0 0 1 2 2 7 7 0 0 1 5 7v5l2 3H3l2-3v-5a7 7 0 0 1 5-7 2 2 0 0 1 2-2ZM9.5 20h5a2.5 2.5 0 0 1-5 0Z";
const STRUCK_BELL = `${BELL}M3 2L22 22`; // what says Silence where words have no room
const TICK = "M4 13l5 6L20 5"; // and Acknowledge
const RANK_WORDS = {
  emergency: say("emergency"),
  alarm: say("alarm"),
  warning: say("warning"),
  caution: say("caution"),
};
/** @type {Partial<Record<import("./model/alerts.js").State, string>>} beside the words of an alert; the key has the others */
const STATE_WORDS = { silenced: say("silenced"), rectified: say("over") };
const URGENT = 2; // of the four ranks, the first ones, which interrupt a screen reader

export class AlertBar extends HTMLElement {
  constructor() {
    super();
    /** @type {Alerts | null} */
    this.alerts = null;
    /** @type {() => void} */
    this.silence = () => undefined;
    this.count = html("span", { class: "count" });
    this.bell = html(
      "button",
      { type: "button", class: "bell", "aria-expanded": "false", click: () => this.open(!this.isOpen) },
      svg("svg", { viewBox: "0 0 24 24", "aria-hidden": "true" }, svg("path", { d: BELL })),
      this.count,
    );
    this.hush = html("button", { type: "button", class: "hush", click: () => this.silence() }, ...said(STRUCK_BELL, say("Silence")));
    this.worst = html("p", { class: "worst" });
    this.aloud = html("span", { class: "unseen", role: "log" }); // its words alone, without key and time
    this.list = html("ul", { class: "all", "aria-label": say("All alerts"), hidden: true });
  }

  connectedCallback() {
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", say("Alerts"));
    this.replaceChildren(this.bell, this.hush, this.worst, this.aloud, this.list);
    addEventListener("keydown", (event) => event.key === "Escape" && this.open(false));
    addEventListener("pointerdown", (event) => {
      if (!this.contains(/** @type {Node} */ (event.target))) this.open(false);
    });
  }

  /**
   * Shows these alerts from now on.
   * @param {Alerts} alerts
   * @param {{ silence(): void }} [sounder] absent where the page makes no sound
   */
  follow(alerts, sounder) {
    this.alerts = alerts;
    this.silence = () => sounder?.silence();
    this.hush.toggleAttribute("hidden", !sounder);
    if (!sounder) this.bell.replaceWith((this.bell = html("span", { class: "bell", role: "img" }, ...this.bell.childNodes)));
    alerts.addEventListener("change", () => this.show());
    this.show();
  }

  get isOpen() {
    return !this.list.hidden;
  }

  /** Opens the list, or shuts it. @param {boolean} wanted */
  open(wanted) {
    if (wanted === this.isOpen) return;
    this.list.hidden = !wanted;
    this.bell.setAttribute("aria-expanded", String(wanted));
    this.show();
  }

  show() {
    const { alerts, bell, count, hush, list, worst } = this;
    if (!alerts) return;
    const { shown } = alerts;
    const owed = shown.filter((each) => each.owed);
    const sounding = owed.filter((each) => each.state === "active");
    write(count, String(owed.length));
    bell.setAttribute("aria-label", say("Alerts: {0} new of {1}", owed.length, shown.length));
    bell.toggleAttribute("data-new", owed.length > 0);
    hush.toggleAttribute("disabled", !sounding.length);
    const urgent = sounding.some((each) => RANKS.indexOf(each.rank) < URGENT);
    this.aloud.setAttribute("aria-live", urgent ? "assertive" : "polite");
    write(this.aloud, sounding.length ? say("{0}: {1}", RANK_WORDS[sounding[0].rank], sounding[0].words) : "");
    this.fill(worst, this.isOpen ? [] : [...sounding, ...shown].slice(0, 1), "span");
    this.fill(list, this.isOpen ? shown : [], "li");
    if (this.isOpen && !shown.length) list.replaceChildren(html("li", { class: "none" }, say("No alerts.")));
  }

  /**
   * Makes an element's entries anew where they have changed, so that no key goes from under a finger.
   * @param {HTMLElement} place
   * @param {Shown[]} shown
   * @param {string} name of an entry's element
   */
  fill(place, shown, name) {
    const now = JSON.stringify(shown.map((each) => [each.key, each.words, each.state, each.by]));
    if (place.dataset.shown !== now) {
      const held = place.contains(document.activeElement) && document.activeElement?.closest(".alert");
      place.dataset.shown = now;
      place.replaceChildren(...shown.map((each) => this.entry(each, name)));
      if (held instanceof HTMLElement) this.hold(place, held.dataset.key ?? "");
    }
    place.querySelectorAll("time").forEach((time, at) => write(time, this.age(shown[at])));
  }

  /** Gives the focus back to the key of an alert, else to that of the first new one. @param {HTMLElement} place @param {string} of its key */
  hold(place, of) {
    const same = [...place.querySelectorAll("button")].find((key) => key.closest(".alert")?.getAttribute("data-key") === of);
    (same ?? this.list.querySelector("button") ?? this.bell).focus();
  }

  /** @param {Shown} alert @param {string} name of its element */
  entry(alert, name) {
    const { by, owed, rank, state } = alert;
    const seen = () => this.alerts?.acknowledge(alert);
    const key = html("button", { type: "button", class: "seen", click: seen }, ...said(TICK, say("Acknowledge")));
    return html(
      name,
      { class: "alert", "data-key": alert.key, "data-rank": rank, "data-state": state, "data-new": owed && state !== "rectified" },
      owed && !by && rank !== "emergency" ? key : html("span", { class: "seen" }, this.answer(alert)),
      svg(
        "svg",
        { viewBox: "0 0 24 24", class: "icon", "aria-hidden": "true" },
        svg("path", { d: SHAPES[rank] }),
        svg("path", { d: "M12 8v7M12 18.5v.1", class: "cut" }),
      ),
      html("span", { class: "rank" }, RANK_WORDS[rank]),
      html("b", {}, ...(STATE_WORDS[state] ? [html("i", {}, STATE_WORDS[state]), " "] : []), alert.words),
      html("time"),
    );
  }

  /** What stands where an alert has no key: that it was seen, or who acknowledges it. @param {Shown} alert */
  answer({ by, owed, rank }) {
    if (!owed) return rank === "caution" ? "" : say("seen");
    return by && rank !== "emergency" ? say("for {0}", by) : "";
  }

  /** How long ago an alert came. @param {Shown} alert */
  age(alert) {
    return clock((this.alerts?.session.seconds ?? 0) - alert.seconds);
  }
}
/** Returns what a key says: words, and a sign that stands for them on a small screen. @param {string} sign @param {string} words */
function said(sign, words) {
  const picture = svg("svg", { viewBox: "0 0 24 24", class: "sign", "aria-hidden": "true" }, svg("path", { d: sign }));
  return [picture, html("span", { class: "words" }, words)];
}

customElements.define("alert-bar", AlertBar);
