// Saves what the page shows: BVH in the unit that is asked for, and the report as the server wrote it.

export function save(text: string, name: string, type: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

export function fileName(model: string, style: string | undefined, seed: string, ending: string): string {
  return [model, style, `seed-${seed}`].filter(Boolean).join('_').replace(/[^\w.-]+/g, '-') + ending;
}
