// Keys that work anywhere on the page but in fields, where they belong to the field.

export function startShortcuts(actions: Record<string, (shift: boolean) => void>): void {
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const target = event.target as HTMLElement;
    const field = target.closest?.('input:not([type=range]), select, textarea');
    // Buttons and links keep the keys that press them; the time line keeps none, its arrows mean the same here.
    const presses = target.closest?.('button, a, summary') && (event.key === ' ' || event.key === 'Enter');
    if (field || presses) return;
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    action(event.shiftKey);
  });
}
