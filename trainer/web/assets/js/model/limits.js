// The limits that the briefing gives, which the crew may not pass.

/**
 * Returns the limits of depth [m] and pitch [deg], null where the exercise has none.
 * @param {import("./session.js").Session} session
 */
export function limitsOf({ exercise }) {
  const limits = exercise.limits ?? ""; // as `depth_m_max:105,pitch_deg_max:15`
  return { depth: limitIn(limits, "depth_m_max"), pitch: limitIn(limits, "pitch_deg_max") };
}

/** @param {string} limits @param {string} name */
function limitIn(limits, name) {
  const found = limits.split(",").find((each) => each.startsWith(`${name}:`));
  return found ? Number(found.split(":")[1]) : null;
}
