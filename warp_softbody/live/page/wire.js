// Decodes the outline and the updates that wire.py describes.

const HEAD_BYTES = 28;

/** Counts of an outline's parts and the places of its numbers by name. */
export function readOutline(text) {
  const outline = JSON.parse(text);
  outline.segmentCount = outline.segments.length / 2;
  outline.pointCount = outline.points + outline.fiberPoints;
  outline.place = new Map(outline.numbers.map((name, index) => [name, index]));
  return outline;
}

/** Makes moments of the bytes of updates; those of a take are differences to the one before. */
export class UpdateDecoder {
  constructor(outline, differences) {
    this.outline = outline;
    this.before = differences ? new Uint16Array(3 * outline.pointCount) : null;
  }

  decode(bytes) {
    const { numbers, segmentCount, pointCount } = this.outline;
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const counts = [view.getUint16(24, true), view.getUint16(26, true)];
    let at = HEAD_BYTES;
    const floats = (count) => {
      const part = bytes.slice(at, at + 4 * count);
      at += 4 * count;
      return new Float32Array(part.buffer);
    };
    const small = (count) => {
      at += count;
      return bytes.slice(at - count, at);
    };
    const values = floats(numbers.length);
    const samples = counts.map((count) => ({ count, values: floats(6 * count) }));
    for (const sample of samples) sample.modes = small(sample.count);
    const contraction = small(segmentCount);
    return {
      time: view.getFloat64(0, true),
      scale: view.getFloat32(8, true),
      origin: [12, 16, 20].map((place) => view.getFloat32(place, true)),
      numbers: values,
      contacts: samples[0],
      patches: samples[1],
      contraction,
      cells: this.cells(bytes, at, 3 * pointCount),
    };
  }

  cells(bytes, at, count) {
    const cells = new Uint16Array(count);
    const before = this.before;
    for (let i = 0; i < count; i++) {
      const told = bytes[at + i] | (bytes[at + count + i] << 8);
      cells[i] = before ? told + before[i] : told;
    }
    if (before) this.before = cells;
    return cells;
  }
}

/** A number of a moment by its name; NaN where the scene has none of that name. */
export function numberOf(outline, moment, name) {
  const place = outline.place.get(name);
  return place === undefined ? NaN : moment.numbers[place];
}

/** A vector of a moment by the first part of its name, into `out`; whether it is finite. */
export function vectorOf(outline, moment, name, out) {
  const read = (axis) => numberOf(outline, moment, `${name}.${axis}`);
  out.set(read("x"), read("y"), read("z"));
  return Number.isFinite(out.x + out.y + out.z);
}
