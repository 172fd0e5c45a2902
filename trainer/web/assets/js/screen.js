// What a page does for a screen that nobody sits at: a wall, a kiosk.

const STILL = 3000; // [ms] without movement, after which the pointer is hidden
const MINUTE = 60_000; // [ms]
const SHIFT = 2; // [px]
/** Where the picture stands, minute by minute, so that no edge burns in. */
const PLACES = [[0, 0], [1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];

/** Keeps the screen lit while the page is seen, where the browser can. */
export function keepAwake() {
  const ask = () => {
    if (!document.hidden) navigator.wakeLock?.request("screen").catch(() => undefined);
  };
  document.addEventListener("visibilitychange", ask);
  ask();
}

/** Hides the pointer while it does not move. */
export function hideStillPointer() {
  let hiding = 0;
  const show = () => {
    document.body.removeAttribute("data-still");
    clearTimeout(hiding);
    hiding = setTimeout(() => document.body.setAttribute("data-still", ""), STILL);
  };
  addEventListener("pointermove", show);
  show();
}

/** Moves the picture a little each minute. @param {HTMLElement} picture */
export function moveEachMinute(picture) {
  let minute = 0;
  setInterval(() => {
    minute += 1;
    const [x, y] = PLACES[minute % PLACES.length];
    picture.style.translate = `${SHIFT * x}px ${SHIFT * y}px`;
  }, MINUTE);
}

/** Leaves a visitor no menu, no zoom and no selection to be caught in. */
export function refuseGestures() {
  for (const what of ["contextmenu", "dragstart", "selectstart", "gesturestart"]) {
    addEventListener(what, (event) => event.preventDefault());
  }
  const zooms = (/** @type {WheelEvent | KeyboardEvent} */ event) =>
    (event.ctrlKey || event.metaKey) && (!("key" in event) || "+-=0".includes(event.key));
  const refuse = (/** @type {WheelEvent | KeyboardEvent} */ event) => {
    if (zooms(event)) event.preventDefault();
  };
  addEventListener("wheel", refuse, { passive: false });
  addEventListener("keydown", refuse);
}
