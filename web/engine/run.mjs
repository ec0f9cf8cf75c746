// Renders by the JavaScript module in Node.js what a request (JSON, on standard input) says; the
// tests' and the benchmark's side of JavaScript.
//   node web/engine/run.mjs < request
// The request: module (path of the .js), scene and eye (paths), widths (acceptance angles times this;
// or none), options (of make_renderer), poses (16 numbers each, row by row), first_frame, times (each
// is rendered so often), responses (a file for what the last time gave, float32). The answer: info of
// the renderer, acceptance_rad of the first ommatidium, seconds of each frame and those of the
// processor, memory_bytes before and after.
import fs from 'node:fs';
import path from 'node:path';

const request = JSON.parse(fs.readFileSync(0, 'utf8'));
const { default: createOmma } = await import(path.resolve(request.module));
const wasmBinary = fs.readFileSync(request.module.replace(/\.js$/, '.wasm'));
const omma = await createOmma({ wasmBinary });
const load = (file) => [path.basename(file), new Uint8Array(fs.readFileSync(file))];

const answer = {};
try {
  const scene = omma.load_scene(...load(request.scene));
  const own = omma.load_eye(...load(request.eye), 1e-3);
  const eye = request.widths ? own.scaled(request.widths) : own;
  const world = omma.make_world(scene);
  const renderer = omma.make_renderer(world, eye, request.options ?? {});
  const responses = [];
  answer.build = omma.build();
  answer.info = renderer.info();
  answer.acceptance_rad = eye.acceptance_rad()[0];
  answer.seconds = [];
  answer.processor_seconds = [];
  answer.memory_bytes = [omma.memory_bytes()];
  for (let time = 0; time < (request.times ?? 1); ++time) {
    responses.length = 0;
    request.poses.forEach((pose, i) => {
      const before = performance.now();
      const used = process.cpuUsage();
      responses.push(renderer.render(pose, (request.first_frame ?? 0) + i));
      answer.processor_seconds.push(process.cpuUsage(used).user / 1e6);
      answer.seconds.push((performance.now() - before) / 1000);
      if (request.options?.error) responses.push(renderer.error());
    });
  }
  answer.memory_bytes.push(omma.memory_bytes());
  if (request.responses) {
    fs.writeFileSync(request.responses, Buffer.concat(responses.map((r) => Buffer.from(r.buffer))));
  }
  for (const handle of [renderer, world, eye, scene]) handle.delete();
} catch (error) {
  answer.error = error.message;
}
console.log(JSON.stringify(answer));
process.exit(0);  // with threads, whose workers would go on
