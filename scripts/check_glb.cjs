// Check GLB files with the Khronos validator: every error and warning is printed, and ends with status 1.
//
//     npm install gltf-validator        (anywhere; NODE_PATH names its node_modules folder)
//     NODE_PATH=node_modules node scripts/check_glb.cjs a.glb b.glb
const fs = require("fs");
const validator = require("gltf-validator");

async function check(path) {
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(path)));
  const { numErrors, numWarnings, numInfos, numHints } = report.issues;
  console.log(`${path}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos, ${numHints} hints`);
  for (const issue of report.issues.messages) {
    if (issue.severity <= 1 || process.env.VERBOSE) console.log(`  ${issue.code} ${issue.pointer}: ${issue.message}`);
  }
  return numErrors + numWarnings;
}

Promise.all(process.argv.slice(2).map(check)).then((counts) => process.exit(counts.some(Boolean) ? 1 : 0));
