// Runs @mapbox/martini for benches/martini/main.rs. The argument is the folder in which the package is installed and files
// are exchanged. Orders are lines of standard input:
//   load SIDE TIMES   reads heights.f32; answers the median milliseconds of `new Martini` and of `createTile`
//   mesh ERROR TIMES  writes three grid points per triangle to mesh.u32; answers the median milliseconds of `getMesh`
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { createInterface } from 'node:readline';

const folder = process.argv[2];
const Martini = createRequire(join(folder, 'package.json'))('@mapbox/martini');

function median(times, work) {
    const taken = [];
    let result;
    for (let i = 0; i < times; i++) {
        const start = performance.now();
        result = work();
        taken.push(performance.now() - start);
    }
    taken.sort((a, b) => a - b);
    return [result, taken[times >> 1]];
}

let side, tile;
for await (const line of createInterface({ input: process.stdin })) {
    const [order, argument, times] = line.split(' ');
    if (order === 'load') {
        side = Number(argument);
        const bytes = readFileSync(join(folder, 'heights.f32'));
        const heights = new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
        const [martini, prepare] = median(Number(times), () => new Martini(side));
        const [made, errors] = median(Number(times), () => martini.createTile(heights));
        tile = made;
        console.log(prepare, errors);
    } else {
        const [mesh, taken] = median(Number(times), () => tile.getMesh(Number(argument)));
        const points = Uint32Array.from(mesh.triangles, v => mesh.vertices[2 * v + 1] * side + mesh.vertices[2 * v]);
        writeFileSync(join(folder, 'mesh.u32'), points);
        console.log(taken);
    }
}
