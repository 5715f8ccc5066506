// SPDX-License-Identifier: BSD-3-Clause
// Writes the stores of this folder with zarrita 0.7.5 and numcodecs 0.3.2 (npm install zarrita numcodecs), and the same
// voxels as labels.nrrd. Run once, by `node make.mjs FOLDER`; the tests read what it has written.
import fs from "node:fs"
import path from "node:path"
import * as zarr from "zarrita"

const folder = process.argv[2]
const shape = [5, 12, 16] // z, y, x
const spacing = [1.25, 0.5, 0.5] // micrometres
const labels = new Uint16Array(shape[0] * shape[1] * shape[2])
function fill(value, [z0, y0, x0], [z1, y1, x1]) {
    for (let z = z0; z < z1; z++)
        for (let y = y0; y < y1; y++)
            for (let x = x0; x < x1; x++) labels[(z * shape[1] + y) * shape[2] + x] = value
}
fill(17, [1, 2, 3], [4, 10, 8])
fill(530, [2, 1, 8], [5, 7, 15])

class Store {
    constructor(name) { this.root = path.join(folder, name) }
    async get(key) { try { return fs.readFileSync(this.root + key) } catch { return undefined } }
    async set(key, bytes) {
        fs.mkdirSync(path.dirname(this.root + key), { recursive: true })
        fs.writeFileSync(this.root + key, bytes)
    }
}

const axes = ["z", "y", "x"].map((name) => ({ name, type: "space", unit: "micrometer" }))
const multiscales = [{ axes, datasets: [{ path: "0", coordinateTransformations: [{ type: "scale", scale: spacing }] }] }]
const image = {
    version: "0.5", multiscales,
    "image-label": {
        colors: [{ "label-value": 17, rgba: [255, 128, 0, 255] }, { "label-value": 530, rgba: [0, 255, 0, 255] }],
        properties: [{ "label-value": 17, name: "nucleus" }, { "label-value": 530, name: "cell wall" }],
    },
}

const little = { name: "bytes", configuration: { endian: "little" } }
const big = { name: "bytes", configuration: { endian: "big" } }
const turned = { name: "transpose", configuration: { order: [2, 0, 1] } }
const zstd = { name: "zstd", configuration: { level: 5, checksum: false } }
const blosc = { name: "blosc", configuration: { cname: "lz4", clevel: 5, shuffle: "shuffle", typesize: 2, blocksize: 0 } }
const stores = { plain: [little], big_turned_zstd: [turned, big, zstd], blosc_lz4: [little, blosc] }

for (const [name, codecs] of Object.entries(stores)) {
    const root = zarr.root(new Store(name + ".zarr"))
    await zarr.create(root, { attributes: { ome: image } })
    const array = await zarr.create(root.resolve("0"), { shape, dtype: "uint16", chunkShape: [3, 12, 10], codecs, fillValue: 0 })
    await zarr.set(array, null, { data: labels, shape, stride: [shape[1] * shape[2], shape[2], 1] })
}
fs.writeFileSync(path.join(folder, "labels.nrrd"), Buffer.concat([Buffer.from(
    `NRRD0004\ntype: uint16\ndimension: 3\nsizes: ${[...shape].reverse().join(" ")}\nspacings: 0.0005 0.0005 0.00125\n` +
    "endian: little\nSegment0_LabelValue:=17\nSegment0_Color:=1 0.50196078 0\nSegment0_Name:=nucleus\n" +
    "Segment1_LabelValue:=530\nSegment1_Color:=0 1 0\nSegment1_Name:=cell wall\nencoding: raw\n\n"), Buffer.from(labels.buffer)]))
