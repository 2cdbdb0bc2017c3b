/** A number of a state within [low, high], to so many decimals; `instead` of anything that is no number. */
export function boundedNumber(value, [low, high], instead, digits = null) {
  const number = Number.isFinite(value) ? Math.min(high, Math.max(low, value)) : instead;
  return digits === null ? number : Number(number.toFixed(digits));
}

/** Those of `joins` that join two of the poses 0 … `last`, at least `gap` apart, at most `most` of them. */
export function possibleJoins(joins, last, gap, most) {
  return joins.filter((join) => Array.isArray(join) && join.length === 2
    && join.every((pose) => Number.isInteger(pose) && pose >= 0 && pose <= last)
    && Math.abs(join[0] - join[1]) >= gap).slice(0, most);
}

/** The part of an address that brings back a state: `#name={…}`, with what differs from `first`. */
export function stateToHash(name, state, first) {
  const changed = Object.entries(state).filter(([key, value]) => JSON.stringify(value) !== JSON.stringify(first[key]));
  return `#${name}=${encodeURIComponent(JSON.stringify(Object.fromEntries(changed)))}`;
}

/** The state that an address names, over `first`; null where it names none for this picture. */
export function stateFromHash(name, hash, first) {
  const head = `#${name}=`;
  if (!hash.startsWith(head)) return null;
  try {
    const changed = JSON.parse(decodeURIComponent(hash.slice(head.length)));
    // A link comes from anywhere: only names that the state has are taken, and only of its type.
    const known = Object.entries(changed).filter(
      ([key, value]) => Object.hasOwn(first, key) && typeof value === typeof first[key]
        && Array.isArray(value) === Array.isArray(first[key]),
    );
    return { ...first, ...Object.fromEntries(known) };
  } catch {
    return null;
  }
}
