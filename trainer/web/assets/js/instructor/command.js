// Command among several instructors: who has it, who asks for it.
import { html, one } from "../draw.js";
import { askAboard, onArrival } from "./log.js";
import { say } from "../words.js";

/** @typedef {import("./desk.js").Desk} Desk */

const OFFERED = 10_000; // [ms] in which the question can be answered

/** Shows who has command where there are several instructors. @param {Desk} desk */
export function furnishCommand(desk) {
  const { session } = desk;
  const bar = new CommandBar(desk);
  session.on("state", () => {
    if (session.joined && !bar.looked) void bar.look();
    if (!session.joined) bar.looked = false;
  });
  onArrival(desk, () => void bar.look());
  session.onFacts({ command: () => void bar.look(), asked: (asker) => bar.ask(asker) });
}

class CommandBar {
  /** @param {Desk} desk */
  constructor(desk) {
    this.desk = desk;
    this.looked = false;
    this.holder = ""; // "" is this page
    this.several = false;
    this.asker = "";
    this.timer = 0; // of the question that is asked now
  }

  /** Finds out who has command. */
  async look() {
    this.looked = true;
    const stations = await askAboard(this.desk);
    this.several = stations.filter(({ role }) => role === "instructor").length > 1;
    const holder = stations.find(({ commands }) => commands);
    if (!this.asker) this.holder = holder && !holder.own ? holder.line : "";
    this.draw();
  }

  /** Somebody asks for command, of whoever has it. @param {string} asker */
  ask(asker) {
    if (this.holder) return;
    this.asker = asker;
    this.draw();
    clearTimeout(this.timer); // of a question before, which would keep command unasked
    this.timer = setTimeout(() => this.settle(), OFFERED);
  }

  settle() {
    if (!this.asker) return;
    this.asker = "";
    void this.look();
  }

  /** @param {string} words the order @param {string} name of the key */
  key(words, name) {
    const give = () => {
      this.asker = "";
      void this.desk.give(words).then(() => this.look());
    };
    return html("button", { type: "button", click: give }, name);
  }

  draw() {
    const bar = one("#command");
    const { asker, holder, several } = this;
    bar.hidden = !several;
    if (asker) {
      const says = html("span", {}, say("The instructor at {0} asks for command.", asker));
      bar.replaceChildren(says, this.key("give command", say("Give command")), this.key("keep command", say("Keep command")));
    } else if (holder) {
      const says = say("The instructor at {0} has command. You watch and mark.", holder);
      bar.replaceChildren(html("span", {}, says), this.key("take command", say("Take command")));
    } else bar.replaceChildren(html("span", {}, say("You have command. Other instructors watch.")));
  }
}
