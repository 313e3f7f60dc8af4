// A tile as it looks: its colours are computed once, and copied as long as the look stays the same.

/** Tiles coloured in one picture at most, so that no picture waits for all of them. */
const MOST_A_PICTURE = 4;

/** @typedef {import("./gl.js").Painter} Painter */
/** @typedef {import("./gl.js").Rectangle} Rectangle */

export class Coloured {
  /** @param {Painter} painter */
  constructor(painter) {
    this.painter = painter;
    /** @type {WebGLTexture | null} */
    this.colours = null;
    /** The look of `colours`. */
    this.key = "";
    /** The look that the tile had last. */
    this.last = "";
  }

  /**
   * Draws a tile by the present look. A look that was another in the picture before may change again at once, as a
   * slider moves: then only what is seen is computed.
   * @param {WebGLTexture} field @param {[number, number]} size @param {Rectangle} place of the whole field within the gain
   * @param {import("./gl.js").At} at
   */
  draw(field, size, place, at) {
    const { painter } = this;
    const { key } = painter;
    if (this.key !== key && this.last === key && painter.colouredNow < MOST_A_PICTURE) {
      this.forget();
      this.colours = painter.coloured(field, size, place);
      this.key = key;
      painter.colouredNow += 1;
    }
    this.last = key;
    if (this.colours && this.key === key) painter.copy(this.colours, at, painter.shown?.opacity ?? 1);
    else painter.draw(field, null, at);
  }

  /** Frees the colours. */
  forget() {
    if (this.colours) this.painter.forget(this.colours);
    this.colours = null;
    this.key = "";
  }
}
