/* Arrays as they come from Python: views of bytes, in notebooks and on pages alike. */

/* The bytes as numbers of a type; copied only where they do not start where such numbers may. */
export function typed(bytes, Type) {
  if (bytes instanceof Type) return bytes;
  const buffer = bytes.buffer ?? bytes;
  const start = bytes.byteOffset ?? 0;
  const length = bytes.byteLength;
  if (start % Type.BYTES_PER_ELEMENT === 0) return new Type(buffer, start, length / Type.BYTES_PER_ELEMENT);
  return new Type(buffer.slice(start, start + length));
}

/* Vertex numbers of triangles, in as many bytes as they were sent. */
export function indices(bytes, vertices) {
  return typed(bytes, vertices <= 65536 ? Uint16Array : Uint32Array);
}

/* Positions that were sent as 16 bits of the box around them. */
export function positions({bytes, low, step}) {
  const steps = typed(bytes, Uint16Array);
  const places = new Float32Array(steps.length);
  for (let i = 0; i < steps.length; i++) places[i] = low[i % 3] + step[i % 3] * steps[i];
  return places;
}
