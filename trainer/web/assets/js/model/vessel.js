// What a boat can do, as the session tells it in facts `range`.

export class Vessel {
  constructor() {
    /** @type {Record<string, number>} */
    this.ranges = {};
    /** @type {[string, number][]} bells as they are ordered, and their turns [kn] */
    this.bells = [];
    /** @type {Record<string, number>} what each tank holds [t] */
    this.tanks = {};
  }

  /** Takes a key and its value, such as `rudder=30` or `bell=ahead full:12`. @param {string} subject */
  take(subject) {
    const equals = subject.indexOf("=");
    const [key, value] = [subject.slice(0, equals), subject.slice(equals + 1)];
    const colon = value.lastIndexOf(":");
    const [name, size] = [value.slice(0, colon), Number(value.slice(colon + 1))];
    if (key === "bell" && !this.bells.some(([each]) => each === name)) this.bells.push([name, size]);
    else if (key === "tank") this.tanks[name] = size;
    else if (key !== "bell") this.ranges[key] = Number(value);
  }

  /** Forgets the bells: another boat may have others. */
  forget() {
    this.bells.length = 0;
  }
}
