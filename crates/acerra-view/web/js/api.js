// Questions to the server. Addresses are relative to the page, whose own address holds the token.

/** An answer that is a refusal. */
export class Refused extends Error {
  /** @param {number} status @param {string} message */
  constructor(status, message) {
    super(message);
    this.status = status;
  }
}

/** @param {Response} response @returns {Promise<Response>} */
async function accepted(response) {
  if (response.ok) return response;
  const text = await response.text();
  let message = text;
  try {
    message = JSON.parse(text).error ?? text;
  } catch {
    // Not every refusal is JSON.
  }
  throw new Refused(response.status, message);
}

/** @param {string} path @param {AbortSignal} [signal] */
export async function getJson(path, signal) {
  return (await accepted(await fetch(path, { signal }))).json();
}

/** @param {string} path @param {AbortSignal} [signal] @returns {Promise<ArrayBuffer>} */
export async function getBytes(path, signal) {
  return (await accepted(await fetch(path, { signal }))).arrayBuffer();
}

/** @param {string} path @param {unknown} body @param {AbortSignal} [signal] */
async function post(path, body, signal) {
  const headers = { "content-type": "application/json" };
  return accepted(await fetch(path, { method: "POST", headers, body: JSON.stringify(body), signal }));
}

/**
 * An image of what is in view.
 * @param {number} run @param {import("./types.js").ImageOrder} order @param {AbortSignal} [signal]
 * @returns {Promise<import("./types.js").Made>}
 */
export async function postImage(run, order, signal) {
  const response = await post(`api/run/${run}/image`, order, signal);
  const told = JSON.parse(response.headers.get("x-acerra-image") ?? "{}");
  return { ...told, values: new Float32Array(await response.arrayBuffer()) };
}

/** @param {number} run @param {import("./types.js").Edits} edits @returns {Promise<string>} */
export async function postCampaign(run, edits) {
  return (await post(`api/run/${run}/campaign`, edits)).text();
}

/** Ends the recording of a live image. */
export async function postStop() {
  await post("stop", { confirmed: true });
}

/**
 * Runs one request at a time: while one is under way only the newest of the others waits.
 * @template T
 */
export class Latest {
  constructor() {
    /** @type {(() => Promise<void>) | null} */
    this.waiting = null;
    this.busy = false;
  }

  /** @param {() => Promise<void>} work */
  run(work) {
    this.waiting = work;
    if (!this.busy) void this.drain();
  }

  async drain() {
    this.busy = true;
    while (this.waiting) {
      const work = this.waiting;
      this.waiting = null;
      await work();
    }
    this.busy = false;
  }
}
