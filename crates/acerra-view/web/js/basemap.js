// Map tiles under the image, from where the user says (`--basemap`).

/** Semi-major axis (m) and squared eccentricity of WGS 84. */
const A = 6378137;
const E2 = 0.00669437999014;

/** Metres a radian of latitude and of longitude at a latitude. @param {number} latitude */
function scales(latitude) {
  const w = Math.sqrt(1 - E2 * Math.sin(latitude) ** 2);
  return { north: (A * (1 - E2)) / w ** 3, east: (A / w) * Math.cos(latitude) };
}

export class Basemap {
  /** @param {HTMLElement} box @param {string} template */
  constructor(box, template) {
    this.template = template;
    this.sheet = document.createElement("div");
    this.sheet.className = "basemap";
    box.prepend(this.sheet);
    /** @type {Map<string, HTMLImageElement>} */
    this.shown = new Map();
  }

  /**
   * Puts the tiles in view under the image. East and north are taken for those of the tangent plane,
   * which is right to a centimetre within a kilometre of the origin.
   * @param {import("./camera.js").Camera} camera @param {number[] | null} origin_deg_m
   */
  draw(camera, origin_deg_m) {
    if (!origin_deg_m) return;
    const [lat0, lon0] = [(origin_deg_m[0] * Math.PI) / 180, (origin_deg_m[1] * Math.PI) / 180];
    const k = scales(lat0);
    const metres = 2 * Math.PI * A * Math.cos(lat0);
    const z = Math.max(0, Math.min(19, Math.ceil(Math.log2((metres * camera.kx) / 256))));
    const n = 2 ** z;
    const column = (/** @type {number} */ x) => n * ((lon0 + x / k.east) / (2 * Math.PI) + 0.5);
    const row = (/** @type {number} */ y) => n * (0.5 - Math.asinh(Math.tan(lat0 + y / k.north)) / (2 * Math.PI));
    const xOf = (/** @type {number} */ c) => ((c / n - 0.5) * 2 * Math.PI - lon0) * k.east;
    const yOf = (/** @type {number} */ r) => (Math.atan(Math.sinh((0.5 - r / n) * 2 * Math.PI)) - lat0) * k.north;
    const view = camera.view();
    const wanted = new Set();
    const [c0, c1] = [Math.floor(column(view.x[0])), Math.floor(column(view.x[1]))];
    const [r0, r1] = [Math.floor(row(view.y[1])), Math.floor(row(view.y[0]))];
    if ((c1 - c0 + 1) * (r1 - r0 + 1) > 200) return;
    for (let r = Math.max(r0, 0); r <= Math.min(r1, n - 1); r++) {
      for (let c = Math.max(c0, 0); c <= Math.min(c1, n - 1); c++) {
        const key = `${z}/${c}/${r}`;
        wanted.add(key);
        let picture = this.shown.get(key);
        if (!picture) {
          picture = new Image();
          picture.alt = "";
          picture.referrerPolicy = "no-referrer";
          picture.src = this.template.replace("{z}", `${z}`).replace("{x}", `${c}`).replace("{y}", `${r}`);
          this.shown.set(key, picture);
          this.sheet.append(picture);
        }
        const [ax, ay] = camera.toScreen(xOf(c), yOf(r));
        const [bx, by] = camera.toScreen(xOf(c + 1), yOf(r + 1));
        Object.assign(picture.style, { left: `${ax}px`, top: `${ay}px`, width: `${bx - ax + 0.5}px`, height: `${by - ay + 0.5}px` });
      }
    }
    for (const [key, picture] of this.shown) {
      if (wanted.has(key)) continue;
      picture.remove();
      this.shown.delete(key);
    }
  }
}
