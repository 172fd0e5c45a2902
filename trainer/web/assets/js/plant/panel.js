// The plant's rows: oil, power, smoke, and the keys of a role that may order them.
import { html, one, write } from "../draw.js";
import { decimals, say } from "../words.js";

/**
 * @typedef {import("../model/session.js").Session} Session
 * @typedef {import("./supply-keys.js").Give} Give
 *
 * A row: its name, what it tells and whether that is unusual, and its keys.
 * @typedef {{ name: string, tell: () => [string, boolean], keys?: Key[] }} Row
 * @typedef {{ word: string, order: string, place: string, stands: string }} Key pressed where the
 *   reading at its place is as it stands
 */

const LOW_OIL = 16; // [MPa] as the session's alert has it
const SMOKE = 5; // [%] likewise
const HALF = 0.5; // of a tank, likewise

/** @type {Record<string, string>} what the words of readings are called here */
const SAID = {
  "standing by": say("standing by"),
  running: say("running"),
  stopped: say("STOPPED"),
  live: say("live"),
  dead: say("DEAD"),
  open: say("open"),
  shut: say("shut"),
  isolated: say("ISOLATED"),
  on: say("on"),
  shed: say("SHED"),
  secured: say("SECURED"),
  exhausting: say("EXHAUSTING"),
};
/** @type {Record<string, string>} */
const CONSUMERS = {
  hydraulic_1: say("oil pump 1"),
  hydraulic_2: say("oil pump 2"),
  hydraulic_vital: say("vital oil pump"),
  trim: say("trim pump"),
  drain: say("drain pump"),
  depth_control: say("depth-control pump"),
  compressor: say("compressor"),
  autopilot: say("autopilot"),
  gyro: say("gyro"),
  log: say("log (speed)"),
  sounder: say("echo sounder"),
  telegraph: say("telegraph"),
  propulsion: say("propulsion"),
};

/** Adds the rows of the plant to its window; returns what shows them. @param {Session} session @param {Give} give */
export function plantRows(session, give) {
  const rows = [...oil(session), ...power(session), ...fire(session)].map(([group, row]) => {
    const made = rowOf(session, give, row);
    one(`[data-plant=${group}]`).append(made.node);
    return made;
  });
  return () => {
    for (const row of rows) row.show();
  };
}

/** @param {Session} session @param {Give} give @param {Row} row */
function rowOf(session, give, { name, tell, keys = [] }) {
  const told = html("span", { class: "told" });
  const may = keys.filter(({ order }) => session.may(order));
  const made = may.map((key) => {
    const click = () => void give(key.order);
    return html("button", { type: "button", "aria-label": `${name}: ${key.word}`, click }, key.word);
  });
  const group = made.length ? html("div", { class: "keys", role: "group", "aria-label": name, "data-control": true }, ...made) : null;
  const node = html("div", { class: "plant-row" }, html("b", {}, name), told, group);
  const show = () => {
    const [words, isUnusual] = tell();
    write(told, words);
    told.toggleAttribute("data-unusual", isUnusual);
    may.forEach(({ place, stands }, at) => {
      const word = session.word(`plant.${place}`);
      made[at].setAttribute("aria-pressed", String(word === stands || (stands === "running" && word === "standing by")));
    });
  };
  return { node, show };
}

/** Returns a key. @param {string} word @param {string} order @param {string} place @param {string} stands @returns {Key} */
function orderKey(word, order, place, stands) {
  return { word, order, place, stands };
}

/** @param {Session} session @returns {[string, Row][]} */
function oil(session) {
  /** What each tank has held at most [L]. @type {Record<string, number>} */
  const most = {};
  const system = (/** @type {string} */ name, /** @type {string} */ title) => ({
    name: title,
    tell: () => {
      const [pressure, level] = ["pressure", "level"].map((what) => session.number(`plant.${name}_${what}`) ?? 0);
      most[name] = Math.max(most[name] ?? 0, level);
      const shown = decimals(pressure, 1);
      const amount = decimals(level, 0);
      if (session.word(`plant.${name}_oil`) === "isolated") return warned(true, say("ISOLATED, {0} MPa, tank {1} L", shown, amount));
      if (pressure < LOW_OIL) return warned(true, say("LOW {0} MPa, tank {1} L", shown, amount));
      if (level < HALF * most[name]) return warned(true, say("{0} MPa, tank LOW {1} L", shown, amount));
      return warned(false, say("{0} MPa, tank {1} L", shown, amount));
    },
    keys: valveKeys(name),
  });
  const pump = (/** @type {string} */ name, /** @type {string} */ title) => ({
    name: title,
    tell: () => stands(session, `pump_${name}`, ["standing by", "running"]),
    keys: [
      orderKey(say("run"), `hydraulic pump ${name} run`, `pump_${name}`, "running"),
      orderKey(say("stop"), `hydraulic pump ${name} stop`, `pump_${name}`, "stopped"),
    ],
  });
  const valve = (/** @type {string} */ name, /** @type {string} */ title) => ({
    name: title,
    tell: () => stands(session, `${name}_oil`, ["open"]),
    keys: valveKeys(name),
  });
  return grouped("oil", [
    system("main", say("Main oil")),
    pump("1", say("Pump 1")),
    pump("2", say("Pump 2")),
    system("vital", say("Vital oil")),
    pump("vital", say("Vital pump")),
    valve("rudder", say("Rudder leg")),
    valve("stern", say("Stern leg")),
    valve("bow", say("Bow leg")),
  ]);
}

/** Returns the keys of a valve of the oil. @param {string} name of a system, or of a surface's leg */
function valveKeys(name) {
  return [
    orderKey(say("Isolate"), `isolate ${name}`, `${name}_oil`, "isolated"),
    orderKey(say("Open"), `open ${name}`, `${name}_oil`, "open"),
  ];
}

/** @param {Session} session @returns {[string, Row][]} */
function power(session) {
  const bus = (/** @type {string} */ name, /** @type {string} */ title) => ({
    name: title,
    tell: () => {
      const [live, wrong] = stands(session, `${name}_bus`, ["live"]);
      const load = say("{0}, {1} kW", live, decimals(session.number(`plant.${name}_load`) ?? 0, 0));
      if (session.word(`plant.${name}_breaker`) !== "open") return warned(wrong, load);
      return warned(true, say("{0}, breaker OPEN", load));
    },
    ...(name === "dc"
      ? {}
      : {
          keys: [
            orderKey(say("Shut"), `breaker ${name} shut`, `${name}_breaker`, "shut"),
            orderKey(say("Open"), `breaker ${name} open`, `${name}_breaker`, "open"),
          ],
        }),
  });
  return grouped("power", [
    bus("port", say("Port bus")),
    bus("starboard", say("Stbd bus")),
    bus("dc", say("DC bus")),
    {
      name: say("Bus tie"),
      tell: () => stands(session, "tie", ["open"]),
      keys: [orderKey(say("Shut"), "bus tie shut", "tie", "shut"), orderKey(say("Open"), "bus tie open", "tie", "open")],
    },
    {
      name: say("Loads"),
      tell: () => stands(session, "loads", ["on"]),
      keys: [orderKey(say("Shed"), "loads shed", "loads", "shed"), orderKey(say("Back"), "loads back", "loads", "on")],
    },
    {
      name: say("Battery"),
      tell: () => {
        const charge = decimals(session.number("plant.charge") ?? 0, 1);
        const left = session.number("plant.overload_left");
        if (left === null) return warned(false, say("{0} %", charge));
        return warned(true, say("{0} %, OVERLOAD: opens in {1} s", charge, decimals(left, 0)));
      },
    },
    {
      name: say("Dead"),
      tell: () => {
        const dead = session.word("plant.dead");
        return dead ? warned(true, dead.split("+").map((each) => CONSUMERS[each] ?? each).join(", ")) : [say("nothing"), false];
      },
    },
  ]);
}

/** @param {Session} session @returns {[string, Row][]} */
function fire(session) {
  const smoke = (/** @type {string} */ name, /** @type {string} */ title) => ({
    name: title,
    tell: () => {
      const seen = session.number(`plant.smoke_${name}`) ?? 0;
      const words = seen > SMOKE ? say("SMOKE {0} %", decimals(seen, 0)) : say("smoke {0} %", decimals(seen, 0));
      return warned(seen > SMOKE || session.word("plant.party") === name, party(session, name, words));
    },
    keys: [orderKey(say("Fight fire"), `fight fire ${name}`, "party", name)],
  });
  return grouped("fire", [
    smoke("forward", say("Forward")),
    smoke("control", say("Control")),
    smoke("aft", say("Aft")),
    {
      name: say("Ventilation"),
      tell: () => stands(session, "ventilation", ["running"]),
      keys: [
        orderKey(say("run"), "ventilation run", "ventilation", "running"),
        orderKey(say("Secure"), "ventilation secure", "ventilation", "secured"),
        orderKey(say("Exhaust"), "ventilation exhaust", "ventilation", "exhausting"),
      ],
    },
  ]);
}

/** Returns the smoke of a compartment, with the party where it is sent there. @param {Session} session @param {string} name @param {string} words */
function party(session, name, words) {
  if (session.word("plant.party") !== name) return words;
  const due = session.number("plant.party_due");
  return due ? say("{0}, party in {1} s", words, decimals(due, 0)) : say("{0}, party at it", words);
}

/** Returns how something stands, and whether that is unusual. @param {Session} session @param {string} place @param {string[]} usual @returns {[string, boolean]} */
function stands(session, place, usual) {
  const word = session.word(`plant.${place}`);
  return warned(!usual.includes(word), SAID[word] ?? word);
}

/** @param {boolean} isUnusual @param {string} words @returns {[string, boolean]} */
function warned(isUnusual, words) {
  return [words, isUnusual];
}

/** @param {string} group @param {Row[]} rows @returns {[string, Row][]} */
function grouped(group, rows) {
  return rows.map((row) => [group, row]);
}
