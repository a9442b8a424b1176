// Values from register words, by the map that the service's own table gives.
export function decode(entry, words, lowFirst, step) {
  if (entry.words === 1) {
    const word = words[0];
    const isSigned = entry.type === "int16";
    const value = isSigned && word > 32767 ? word - 65536 : word;
    if (isSigned && word === 32768) return NaN;
    return value * step;
  }
  const [high, low] = lowFirst ? [words[1], words[0]] : words;
  const view = new DataView(new ArrayBuffer(4));
  view.setUint16(0, high);
  view.setUint16(2, low);
  if (entry.type === "float32") return view.getFloat32(0);
  if (entry.type === "int32") return view.getInt32(0) === -2147483648 ? NaN : view.getInt32(0) * step;
  return view.getUint32(0) * step;
}

export function shown(entry, value) {
  if (entry.type === "bits") return value.toString(2).padStart(16, "0").replace(/(....)(?=.)/g, "$1 ");
  if (Number.isNaN(value)) return "unknown";
  if (entry.type === "float32") return Math.abs(value) > 1e7 || (value !== 0 && Math.abs(value) < 1e-4) ? value.toExponential(4) : String(Number(value.toPrecision(7)));
  const decimals = entry.step >= 1 ? 0 : Math.ceil(-Math.log10(entry.step) - 1e-9);
  return value.toFixed(decimals);
}

// A reader by name: registers("uptime")
export function reader(map, service) {
  const byName = new Map(map.registers.map((entry) => [entry.name, entry]));
  return (name) => {
    const entry = byName.get(name);
    if (!entry) return NaN;
    const isLowFirst = entry.type === "float32" && service.float_low_first;
    return decode(entry, service.registers.slice(entry.address, entry.address + entry.words), isLowFirst, entry.step_is_configured ? service.step_mm : entry.step);
  };
}
