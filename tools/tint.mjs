// Compiles WGSL with Tint, the shader compiler of Chromium's WebGPU. It rejects things that naga lets pass, such
// as a derivative in non-uniform control flow. Dawn's null backend runs it, so neither a GPU nor a driver is needed.
//
//     node tools/tint.mjs PACKAGES FILE.wgsl...
//
// PACKAGES is a folder in which the npm package "webgpu" is installed. Prints a line for each file, followed by the
// compiler's messages, and exits with 1 if a file is rejected. `./dev tint` does it all.

import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

async function openDevice(packages) {
  const entry = createRequire(resolve(packages, 'from-here.js')).resolve('webgpu');
  const { create } = await import(pathToFileURL(entry));
  const gpu = create(['backend=null']);
  const adapter = await gpu.requestAdapter();
  if (!adapter) throw new Error("Dawn's null backend offers no adapter");
  // No optional features: what compiles here compiles on every WebGPU device. The gpu object is handed out too,
  // because the device does not outlive it.
  return { gpu, device: await adapter.requestDevice() };
}

/** Prints the verdict on one file and returns whether it was accepted. */
async function check(device, file) {
  const code = await readFile(file, 'utf8');
  device.pushErrorScope('validation');
  const { messages } = await device.createShaderModule({ label: file, code }).getCompilationInfo();
  const failure = await device.popErrorScope();

  const errors = messages.filter(({ type }) => type === 'error').length;
  const accepted = !failure && errors === 0;
  console.log(`${accepted ? 'ok      ' : 'REJECTED'} ${file}`);
  for (const { type, lineNum, linePos, message } of messages) {
    console.log(`    ${lineNum}:${linePos} ${type}: ${message}`);
  }
  if (failure && errors === 0) console.log(`    ${failure.message.trim().replaceAll('\n', '\n    ')}`);
  return accepted;
}

const [packages, ...files] = process.argv.slice(2);
if (files.length === 0) {
  console.error('usage: node tools/tint.mjs PACKAGES FILE.wgsl...');
  process.exit(2);
}

const { gpu, device } = await openDevice(packages);
let rejected = 0;
for (const file of files) {
  if (!(await check(device, file))) rejected += 1;
}
console.log(`${files.length - rejected} of ${files.length} accepted by Tint`);
// Dawn keeps the event loop alive, so the script has to end itself.
process.exit(rejected === 0 ? 0 : 1);
