// Checks .glb files with Khronos's validator: node tests/gltf/validate.js FILE... Prints each
// finding, including hints, and exits with 1 if there is any, with 2 if the validator isn't
// installed.
"use strict";

const fs = require("fs");

let validator;
try {
  validator = require("gltf-validator");
} catch (error) {
  console.error("the validator of glTF is not installed; run deploy/install-deps");
  process.exit(2);
}

const judge = async (files) => {
  let bad = files.length === 0;
  for (const file of files) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
    for (const issue of report.issues.messages) {
      bad = true;
      console.log(`${file}: ${issue.code} at ${issue.pointer || issue.offset}: ${issue.message}`);
    }
  }
  console.log(`${files.length} files judged`);
  process.exit(bad ? 1 : 0);
};

judge(process.argv.slice(2));
