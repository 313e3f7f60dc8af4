// What the page shows: numbers under a pane, colours at a place.

import assert from "node:assert/strict";

/** The numbers of a readout. @param {import("playwright-core").Page} page @param {string} list */
export async function readout(page, list) {
  const rows = await page.$$eval(`#${list} div`, (divs) => divs.map((div) => [div.children[0].textContent, div.children[1].textContent]));
  return Object.fromEntries(rows.map(([name, text]) => [name, Number((text ?? "").replace("−", "-").replace(/[^0-9.e-].*$/, ""))]));
}

/** Where a place of a pane, such as `image` or `cuts.cuts.0`, is on the screen. @param {import("playwright-core").Page} page @param {string} pane @param {number} x @param {number} y */
export function onScreen(page, pane, x, y) {
  return page.evaluate(([path, wx, wy]) => {
    const { camera, surface } = path.split(".").reduce((/** @type {any} */ o, key) => o[key], /** @type {any} */ (window).acerra).pane;
    const box = surface.getBoundingClientRect();
    const [sx, sy] = camera.toScreen(wx, wy);
    return /** @type {[number, number]} */ ([box.left + sx, box.top + sy]);
  }, /** @type {[string, number, number]} */ ([pane, x, y]));
}

/**
 * The drawn colour at a place, without what is drawn over it or (`over`) of that alone.
 * @param {import("playwright-core").Page} page @param {string} pane @param {number} x @param {number} y @param {boolean} [over] @returns {Promise<number[]>}
 */
export function colourAt(page, pane, x, y, over = false) {
  return page.evaluate(
    ([path, wx, wy, isOver]) => {
      const shown = path.split(".").reduce((/** @type {any} */ o, key) => o[key], /** @type {any} */ (window).acerra).pane;
      shown.draw();
      const [sx, sy] = shown.camera.toScreen(wx, wy).map((/** @type {number} */ v) => Math.floor(v * shown.ratio));
      if (isOver) return [...shown.context.getImageData(sx, sy, 1, 1).data];
      const { gl, canvas } = shown.painter;
      // The field alone: a drawing may have been laid over it.
      shown.painter.begin(shown.camera.width, shown.camera.height, shown.ratio);
      shown.onField(shown.ratio);
      const pixel = new Uint8Array(4);
      gl.readPixels(sx, canvas.height - 1 - sy, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      return [...pixel];
    },
    /** @type {[string, number, number, boolean]} */ ([pane, x, y, over]),
  );
}

/** @param {number[]} found @param {number[]} expected @param {number} within @param {string} what */
export function near(found, expected, within, what) {
  assert.ok(expected.every((v, k) => Math.abs(found[k] - v) <= within), `${what}: expected ${expected}, found ${found}`);
}

/** Zooms until a pixel of the image takes several of the screen. @param {import("playwright-core").Page} page @param {number} x @param {number} y */
export async function zoomTo(page, x, y) {
  await page.evaluate(([wx, wy]) => {
    const { pane } = /** @type {any} */ (window).acerra.image;
    Object.assign(pane.camera, { x: wx, y: wy, kx: 1200, ky: 1200 });
    pane.invalidate();
  }, [x, y]);
  await page.waitForFunction(() => {
    const { image } = /** @type {any} */ (window).acerra;
    image.pane.draw();
    return image.own.layer.complete;
  });
}
