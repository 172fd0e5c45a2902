// Orders in the grammar's words, read by the session's own tables of order words.
import { HEADS, ORDERS } from "./order-table.js";

/** Returns the order word of an order: `plan` of `at 600 s casualty gyro-stuck`. @param {string} order */
export function wordOf(order) {
  const [first, second] = order.trim().toLowerCase().split(" ");
  return HEADS[`${first} ${second}`] ?? HEADS[first] ?? first;
}

/** Returns an order without its first word. @param {string} order */
export function objectOf(order) {
  return order.trim().split(" ").slice(1).join(" ");
}

/** Whether an order moves the boat, so that it acts once time runs. @param {string} order */
export function movesBoat(order) {
  return ORDERS[wordOf(order)]?.obeyer === ORDERS.sea.obeyer;
}

/**
 * Whether a role may give an order in a state of the session.
 * @param {string} order
 * @param {string} role
 * @param {import("./session.js").State} state
 */
export function mayGive(order, role, state) {
  const rule = ORDERS[wordOf(order)];
  if (!rule?.roles.includes(role)) return false;
  return (state !== "replay" || rule.inReplay) && (state !== "ended" || rule.afterEnd);
}
