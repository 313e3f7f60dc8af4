// Pointers, wheel and keys on a pane.

/**
 * @typedef {object} Listener
 * @property {(sx: number, sy: number) => void} hover
 * @property {() => void} leave
 * @property {(sx: number, sy: number) => void} click
 * @property {(from: [number, number], to: [number, number], done: boolean) => boolean} drag true where it takes the drag for itself
 * @property {() => void} moved after the view has changed
 */

const CLICK_PIXELS = 5;
const ZOOM_STEP = 1.3;

/** @param {HTMLElement} surface @param {import("./camera.js").Camera} camera @param {Listener} listener */
export function listen(surface, camera, listener) {
  /** @type {Map<number, [number, number]>} */
  const down = new Map();
  /** @type {[number, number] | null} */
  let start = null;
  let far = false;
  let taken = false;

  const place = (/** @type {PointerEvent | WheelEvent} */ event) => {
    const box = surface.getBoundingClientRect();
    return /** @type {[number, number]} */ ([event.clientX - box.left, event.clientY - box.top]);
  };

  surface.addEventListener("pointerdown", (event) => {
    surface.setPointerCapture(event.pointerId);
    down.set(event.pointerId, place(event));
    if (down.size === 1) [start, far, taken] = [place(event), false, false];
  });
  surface.addEventListener("pointermove", (event) => {
    const now = place(event);
    const before = down.get(event.pointerId);
    if (!before || !start) return listener.hover(...now);
    if (down.size === 1) {
      far ||= Math.hypot(now[0] - start[0], now[1] - start[1]) > CLICK_PIXELS;
      if (far) {
        taken = listener.drag(start, now, false);
        if (!taken) {
          camera.pan(now[0] - before[0], now[1] - before[1]);
          listener.moved();
        }
      }
    } else {
      far = true;
      const other = [...down].find(([id]) => id !== event.pointerId)?.[1] ?? before;
      const length = (/** @type {[number, number]} */ p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      camera.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
      camera.zoomAt((now[0] + other[0]) / 2, (now[1] + other[1]) / 2, length(now) / Math.max(length(before), 1));
      listener.moved();
    }
    down.set(event.pointerId, now);
  });
  const end = (/** @type {PointerEvent} */ event) => {
    if (down.delete(event.pointerId) && down.size === 0 && start) {
      if (!far && event.type === "pointerup") listener.click(...place(event));
      if (taken) listener.drag(start, place(event), true);
      start = null;
    }
  };
  surface.addEventListener("pointerup", end);
  surface.addEventListener("pointercancel", end);
  surface.addEventListener("pointerleave", () => listener.leave());
  surface.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      camera.zoomAt(...place(event), Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)));
      listener.moved();
    },
    { passive: false },
  );
  surface.addEventListener("keydown", (event) => {
    const middle = /** @type {[number, number]} */ ([camera.width / 2, camera.height / 2]);
    const step = event.shiftKey ? 8 : 48;
    /** @type {Record<string, () => void>} */
    const keys = {
      ArrowLeft: () => camera.pan(step, 0),
      ArrowRight: () => camera.pan(-step, 0),
      ArrowUp: () => camera.pan(0, step),
      ArrowDown: () => camera.pan(0, -step),
      "+": () => camera.zoomAt(...middle, ZOOM_STEP),
      "=": () => camera.zoomAt(...middle, ZOOM_STEP),
      "-": () => camera.zoomAt(...middle, 1 / ZOOM_STEP),
      "0": () => camera.fit(camera.bounds),
      Enter: () => listener.click(...middle),
    };
    const action = keys[event.key];
    if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action();
    listener.hover(...middle);
    listener.moved();
  });
}
