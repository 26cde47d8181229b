// Talking to the program. Requests of one kind follow one another, and of those that wait only the
// last is sent: a slider that is dragged never makes a queue.

let sayWrong = () => {};
export function onRefusal(say) {
  sayWrong = say;
}

async function post(action, values) {
  const query = new URLSearchParams(values).toString();
  try {
    const reply = await fetch(query ? `${action}?${query}` : action, { method: "POST" });
    if (!reply.ok) sayWrong(await reply.text());
  } catch {
    // The stream of events tells that the program has gone.
  }
}

const waiting = new Map();

// `lane` names what must not overtake itself; `merge(old, new)` joins a request that still waits with
// the next one, instead of dropping it.
export function send(action, values = {}, lane = action, merge = null) {
  const entry = waiting.get(lane);
  if (entry) {
    entry.next = { action, values: entry.next && merge ? merge(entry.next.values, values) : values };
    return;
  }
  const mine = { next: { action, values } };
  waiting.set(lane, mine);
  (async () => {
    while (mine.next) {
      const { action: now, values: given } = mine.next;
      mine.next = null;
      await post(now, given);
    }
    waiting.delete(lane);
  })();
}

export async function ask(path, values) {
  const reply = await fetch(`${path}?${new URLSearchParams(values)}`);
  return reply.ok ? reply.json() : null;
}
