// Alerts, as the session's own table has them: python -m helpers.page_alerts makes this.
import { say } from "../words.js";

/** How long until an alert of that rank sounds again [s]. @type {Record<string, number>} */
export const PACES = { emergency: 2, alarm: 10, warning: 60 };

/** The title of each alert, by its name. @type {Record<string, () => string>} */
export const TITLES = {
  "collapse": () => say("Hull collapsed"),
  "collision": () => say("Collision"),
  "beyond test depth": () => say("Beyond test depth"),
  "test depth": () => say("Test depth passed"),
  "near test depth": () => say("Near test depth"),
  "mast out": () => say("Too much mast"),
  "sail near the surface": () => say("Sail near the surface"),
  "aground": () => say("Aground"),
  "approach": () => say("Closest approach"),
  "broached": () => say("Broached"),
  "depth_m_max": () => say("Limit passed"),
  "depth_m_min": () => say("Limit passed"),
  "pitch_deg_max": () => say("Limit passed"),
  "heel_deg_max": () => say("Limit passed"),
  "speed_kn_max": () => say("Limit passed"),
  "speed_kn_min": () => say("Limit passed"),
  "speed_over_ground_kn_max": () => say("Limit passed"),
  "validity_level_max": () => say("Limit passed"),
  "clearance_m_min": () => say("Limit passed"),
  "cpa_m_min": () => say("Limit passed"),
  "faster than the mast stands": () => say("Mast shakes"),
  "outside the equations": () => say("Outside the equations"),
  "emergency ascent": () => say("Emergency ascent"),
  "astern": () => say("Planes amidships"),
  "hover lost": () => say("Hovering given up"),
  "trim short": () => say("No water to trim"),
  "speed not reached": () => say("Speed not reached"),
  "engine limited": () => say("Engine limited"),
  "rudder short on the X-tail": () => say("Rudder short"),
  "stern short on the X-tail": () => say("Planes short"),
  "followed by a sea that the filter cannot follow": () => say("Following sea"),
  "equations extrapolated": () => say("Equations extrapolated"),
  "beyond the chart": () => say("Beyond the chart"),
  "surfaced": () => say("Surfaced"),
  "afloat": () => say("Afloat"),
  "": () => say("Remark"),
};
