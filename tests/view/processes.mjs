// lariat's processes, for the tests in this folder.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

/** Running processes, which end with a failed test. */
const running = new Set();
/** Folder that they are started in, so that a chain writes its files nowhere else. */
export const folder = mkdtempSync(join(tmpdir(), "lariat-view-"));
process.on("exit", () => {
  running.forEach((one) => one.kill("SIGTERM"));
  rmSync(folder, { recursive: true, force: true });
});

/** Starts lariat, and waits for output that matches `until`; `found` is the match. */
export async function start(lariat, words, until) {
  const started = spawn(lariat, words, { cwd: folder, stdio: ["ignore", "pipe", "pipe"] });
  running.add(started);
  started.on("exit", () => running.delete(started));
  let said = "";
  started.stdout.resume();
  const found = await new Promise((resolve, reject) => {
    started.stderr.on("data", (bytes) => {
      said += bytes;
      const match = said.match(until);
      if (match) resolve(match);
    });
    started.on("exit", (code) => reject(new Error(`lariat ${words.join(" ")} ended with ${code}: ${said}`)));
  });
  const ended = new Promise((resolve) => started.on("exit", resolve));
  return {
    found,
    pid: started.pid,
    async end() {
      started.kill("SIGINT");
      await ended;
    },
  };
}

export const chain = (lariat, ...words) => start(lariat, ["run", "--rig", "cell", ...words], /→/);
export const page = (lariat, port = 0) => start(lariat, ["view", "--rig", "cell", "--port", `${port}`], /http:\S+/);

/** Waits until a condition holds. */
export async function holds(what, test, patience_ms = 20_000) {
  const until = Date.now() + patience_ms;
  for (;;) {
    const value = await test();
    if (value) return value;
    if (Date.now() > until) throw new Error(`${what}: not within ${patience_ms / 1000} s`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}
