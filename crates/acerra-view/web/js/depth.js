// Depth below the ground from the optical length of a wave that goes straight down.

/** @typedef {[number | null, number][]} Soil thickness in metres (none of the last) and refractive index of every layer, from the top */

/** Depth (m) after an optical length below the surface (m); above the surface the length itself. @param {number} optical @param {Soil} soil */
export function depthOf(optical, soil) {
  let [left, depth] = [optical, 0];
  for (const [thickness, index] of soil) {
    if (left <= 0 || thickness === null || left <= thickness * index) return depth + (left > 0 ? left / index : left);
    left -= thickness * index;
    depth += thickness;
  }
  return depth + left;
}

/** The optical length down to a depth. @param {number} depth @param {Soil} soil */
export function opticalOf(depth, soil) {
  let [left, optical] = [depth, 0];
  for (const [thickness, index] of soil) {
    if (left <= 0 || thickness === null || left <= thickness) return optical + (left > 0 ? left * index : left);
    left -= thickness;
    optical += thickness * index;
  }
  return optical + left;
}
