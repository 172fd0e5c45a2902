// The boats of a class as its server tells them: who has a seat where, and what has become of each.

export const BOATS_PERIOD = 2000; // [ms] between looks

/**
 * @typedef {{ number: number, name: string, crew: number, names?: string[], state?: string,
 *   resumed?: number }} BoatRow who is aboard, its state, and how often it was begun again are told to an instructor alone
 * @typedef {{ boats: BoatRow[], seat: number | null, guarded: boolean,
 *   shown: number }} Boats `seat` is 0 for an instructor's, `shown` where no boat is shown to all
 */

/** Asks how the boats are; null where nobody answers. @param {string} at where the class is @returns {Promise<Boats | null>} */
export async function askBoats(at = "./") {
  const told = await fetch(`${at}boats`).catch(() => null);
  return told?.ok ? told.json() : null;
}
