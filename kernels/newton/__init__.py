"""Newton iterations that never diverge: what an iterate leaves, and whether it is accepted."""
