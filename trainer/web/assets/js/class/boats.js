// The boats of a class as its server tells them: who has a seat where, and what has become of each.

export const BOATS_PERIOD = 2000; // [ms] between looks

/**
 * @typedef {{ number: number, name: string, crew: number, names?: string[], state?: string,
 *   resumed?: number }} BoatRow who is aboard, its state, and how often it was begun again are told to an instructor alone
 * @typedef {{ boats: BoatRow[], seat: number | null, guarded: boolean }} Boats `seat` is 0 for an instructor's
 */

/** Asks how the boats are; null where nobody answers. @returns {Promise<Boats | null>} */
export async function askBoats() {
  const told = await fetch("./boats").catch(() => null);
  return told?.ok ? told.json() : null;
}
