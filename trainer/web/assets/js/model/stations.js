// Who is here, as the session tells it in facts before its answer to `who`.

/**
 * @typedef {{ role: string, called: string, line: string, own: boolean, commands: boolean,
 *   ready: boolean }} Aboard a station; `own` is that of this page
 */

export class Stations {
  constructor() {
    /** @type {Aboard[]} as they were told last */
    this.all = [];
    /** @type {Aboard[]} as they are being told */
    this.coming = [];
    this.expected = 0; // how many are told
  }

  /** @param {number} count of the stations that are told now */
  expect(count) {
    [this.coming, this.expected] = [[], count];
  }

  /** @param {string} subject role, called, what it is or has, and line of one that is here */
  add(subject) {
    const [role, called, marks, ...line] = subject.split(",");
    const [own, commands, ready] = ["you", "command", "ready"].map((mark) => marks.split(" ").includes(mark));
    this.coming.push({ role, called, line: line.join(","), own, commands, ready });
    if (this.coming.length >= this.expected) this.all = this.coming;
  }
}
