// Two texts line by line: which lines of the old one are gone, which of the new one are there instead.
const MOST_CELLS = 4e6;  // of the table of common lines; beyond it what lies between is taken as replaced
const CONTEXT = 2;

export const linesOf = (text) => text.replace(/\n$/, "").split("\n");

// [{sign: " " | "-" | "+", text, was, is}]: line numbers from 1, of the old and of the new text
export function difference(oldText, newText) {
  const [a, b] = [linesOf(oldText), linesOf(newText)];
  let first = 0;
  while (first < a.length && first < b.length && a[first] === b[first]) ++first;
  let last = 0;
  while (last < a.length - first && last < b.length - first && a[a.length - 1 - last] === b[b.length - 1 - last]) ++last;
  const rows = [];
  const same = (i, j) => rows.push({ sign: " ", text: a[i], was: i + 1, is: j + 1 });
  const gone = (i) => rows.push({ sign: "-", text: a[i], was: i + 1, is: null });
  const added = (j) => rows.push({ sign: "+", text: b[j], was: null, is: j + 1 });
  for (let i = 0; i < first; ++i) same(i, i);
  between(a, b, first, a.length - last, b.length - last, { same, gone, added });
  for (let i = last; i > 0; --i) same(a.length - i, b.length - i);
  return rows;
}

function between(a, b, first, endA, endB, { same, gone, added }) {
  const [rows, columns] = [endA - first, endB - first];
  const common = rows * columns <= MOST_CELLS ? commonLengths(a, b, first, rows, columns) : null;
  const at = (i, j) => (common ? common[(i - first) * (columns + 1) + (j - first)] : 0);
  let [i, j] = [first, first];
  while (i < endA || j < endB) {
    if (common && i < endA && j < endB && a[i] === b[j]) same(i++, j++);
    else if (i < endA && (j === endB || at(i + 1, j) >= at(i, j + 1))) gone(i++);
    else added(j++);
  }
}

// How many lines the rests from (i, j) on have in common, in order.
function commonLengths(a, b, first, rows, columns) {
  const width = columns + 1;
  const lengths = new Uint16Array((rows + 1) * width);
  for (let i = rows - 1; i >= 0; --i)
    for (let j = columns - 1; j >= 0; --j)
      lengths[i * width + j] = a[first + i] === b[first + j] ? lengths[(i + 1) * width + j + 1] + 1 : Math.max(lengths[(i + 1) * width + j], lengths[i * width + j + 1]);
  return lengths;
}

// What has changed with a little around it; null where lines are left out.
export function shortened(rows) {
  const isNear = rows.map(() => false);
  rows.forEach((row, i) => { if (row.sign !== " ") isNear.fill(true, Math.max(0, i - CONTEXT), i + CONTEXT + 1); });
  const kept = [];
  rows.forEach((row, i) => {
    if (isNear[i]) kept.push(row);
    else if (kept.length && kept.at(-1) !== null) kept.push(null);
  });
  return kept.at(-1) === null ? kept.slice(0, -1) : kept;
}

export function counted(rows) {
  const count = (sign) => rows.filter((row) => row.sign === sign).length;
  return { added: count("+"), removed: count("-") };
}
