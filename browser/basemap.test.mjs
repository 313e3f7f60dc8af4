// Map tiles under the image, from a server and a directory of the test's own: a tile's colour is its number.

import assert from "node:assert/strict";
import { mkdirSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";
import { after, before, test } from "node:test";
import zlib from "node:zlib";
import { chromiumPath, demo, folder, launch, open, serve, shot, tidy } from "./harness.mjs";
import { onScreen } from "./look.mjs";

const skip = chromiumPath() ? false : "no Chromium is installed here";
const TILES = join(folder, "tiles");

/** @type {import("playwright-core").Browser} */
let browser;
/** @type {import("node:http").Server} */
let tileServer;
/** Addresses that were asked for. @type {string[]} */
const asked = [];

before(async () => {
  if (skip) return;
  browser = await launch();
  tileServer = createServer((request, response) => {
    asked.push(request.url ?? "");
    const numbers = /^\/(\d+)\/(\d+)\/(\d+)\.png$/.exec(request.url ?? "")?.slice(1).map(Number);
    if (!numbers) {
      response.writeHead(404).end();
      return;
    }
    const picture = png(colourOf(numbers));
    // The same tiles in a directory, for the second test.
    mkdirSync(join(TILES, `${numbers[0]}/${numbers[1]}`), { recursive: true });
    writeFileSync(join(TILES, `${numbers.join("/")}.png`), picture);
    response.writeHead(200, { "content-type": "image/png" }).end(picture);
  });
  await new Promise((done) => tileServer.listen(0, "127.0.0.1", () => done(null)));
});
after(async () => {
  await browser?.close();
  tileServer?.close();
  tidy();
});

/** @param {number[]} tile zoom, column, row */
const colourOf = ([z, x, y]) => [(37 * x) % 256, (59 * y) % 256, 10 * z];

/** A picture of one colour. @param {number[]} colour */
function png(colour) {
  const row = Buffer.concat([Buffer.from([0]), Buffer.alloc(3 * 256, Buffer.from(colour))]);
  const chunk = (/** @type {string} */ name, /** @type {Buffer} */ body) => {
    const part = Buffer.concat([Buffer.from(name), body]);
    const [length, crc] = [Buffer.alloc(4), Buffer.alloc(4)];
    length.writeUInt32BE(body.length);
    crc.writeUInt32BE(/** @type {any} */ (zlib).crc32(part));
    return Buffer.concat([length, part, crc]);
  };
  const head = Buffer.from([0, 0, 1, 0, 0, 0, 1, 0, 8, 2, 0, 0, 0]);
  const body = zlib.deflateSync(Buffer.concat(Array(256).fill(row)));
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", head), chunk("IDAT", body), chunk("IEND", Buffer.alloc(0))]);
}

/** Colours of the page at points, as it is seen. @param {import("playwright-core").Page} page @param {number[][]} points @returns {Promise<number[][]>} */
async function seen(page, points) {
  const picture = (await page.screenshot()).toString("base64");
  const reader = await browser.newPage();
  const colours = await reader.evaluate(async ([data, places]) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.width, image.height];
    const c = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    c.drawImage(image, 0, 0);
    return places.map(([x, y]) => [...c.getImageData(Math.round(x), Math.round(y), 1, 1).data].slice(0, 3));
  }, /** @type {[string, number[][]]} */ ([picture, points]));
  await reader.close();
  return colours;
}

/** Column and row, with their fractions, of a place in Web Mercator. @param {number} z @param {number[]} place latitude and longitude in degrees */
function tileOf(z, [latitude, longitude]) {
  const sin = Math.sin((latitude * Math.PI) / 180);
  return [2 ** z * (longitude / 360 + 0.5), 2 ** z * (0.5 - Math.atanh(sin) / (2 * Math.PI))];
}

/** Asserts that the tiles under the image are those of their places. @param {import("playwright-core").Page} page */
async function check(page) {
  // The tiles alone, 300 m across.
  await page.$eval("#opacity", (input) => {
    /** @type {HTMLInputElement} */ (input).value = "0";
    input.dispatchEvent(new Event("input", { bubbles: true }));
  });
  await page.evaluate(() => {
    const { pane } = /** @type {any} */ (window).acerra.image;
    Object.assign(pane.camera, { x: 9, y: 0, kx: 2, ky: 2 });
    pane.draw();
  });
  await page.waitForFunction(() => [...document.querySelectorAll(".basemap img")].every((one) => /** @type {HTMLImageElement} */ (one).complete && /** @type {HTMLImageElement} */ (one).naturalWidth > 0));
  await page.waitForTimeout(200);
  const zoom = 18;
  const tiles = new Set();
  for (let east = -110; east <= 120; east += 23) {
    for (let north = -120; north <= 120; north += 27) {
      const [, lat, lon] = await page.evaluate(async ([x, y]) => {
        const told = await (await fetch(`api/run/0/cursor?x_m=${x}&y_m=${y}`)).json();
        return [0, ...told.place_deg_m];
      }, [east, north]);
      const [column, row] = tileOf(zoom, [lat, lon]);
      // A pixel of the screen is a 230th of a tile: beside an edge either colour may be seen.
      if ([column, row].some((v) => Math.abs(v - Math.round(v)) < 0.012)) continue;
      // The track and its numbers lie over the tiles.
      if (Math.abs(north) < 8 && east > -10 && east < 40) continue;
      const tile = [zoom, Math.floor(column), Math.floor(row)];
      const [found] = await seen(page, [await onScreen(page, "image", east, north)]);
      assert.deepEqual(found, colourOf(tile), `${east} m east, ${north} m north: tile ${tile}`);
      tiles.add(tile.join("/"));
    }
  }
  assert.ok(tiles.size >= 6, [...tiles].join(" "));
}

test("tiles of a server lie under their places, and nothing else is loaded", { skip }, async () => {
  const { port } = /** @type {import("node:net").AddressInfo} */ (tileServer.address());
  const server = await serve(demo().slice(0, 1), ["--basemap", `http://127.0.0.1:${port}/{z}/{x}/{y}.png`]);
  const { page, complaints, hosts, close } = await open(browser, server.address);
  await check(page);
  await shot(page, "basemap");
  assert.ok(asked.length > 0 && asked.every((path) => /^\/\d+\/\d+\/\d+\.png$/.test(path)), asked.join(" "));
  assert.deepEqual([...new Set(hosts)].sort(), [new URL(server.address).origin, `http://127.0.0.1:${port}`].sort());
  assert.deepEqual(complaints, []);
  await close();
  server.stop();
});

test("tiles of a directory lie under their places, and no other server is asked", { skip }, async () => {
  const before = asked.length;
  const server = await serve(demo().slice(0, 1), ["--tiles", TILES]);
  const { page, hosts, close } = await open(browser, server.address);
  await check(page);
  assert.equal(asked.length, before);
  assert.deepEqual([...new Set(hosts)], [new URL(server.address).origin]);
  const status = (/** @type {string} */ path) => page.evaluate(async (p) => (await fetch(p)).status, path);
  for (const path of ["map/18/0/0", "map/18/1/..%2f..%2fx", "map/a/b/c"]) assert.ok([400, 404].includes(await status(path)), path);
  await close();
  server.stop();
});
