/** The outbox on disk: IndexedDB, or memory where the browser forbids it (private windows). */
import type { OutboxEntry, OutboxStorage } from './outbox';

const NAME = 'pointbrush';
const STORE = 'outbox';

export async function openStorage(): Promise<OutboxStorage> {
  try {
    return new DatabaseStorage(await openDatabase());
  } catch {
    return new MemoryStorage();
  }
}

export class MemoryStorage implements OutboxStorage {
  load(): Promise<OutboxEntry[]> {
    return Promise.resolve([]);
  }
  put(): void {
    // The outbox itself holds the entries.
  }
  remove(): void {
    // As above.
  }
}

class DatabaseStorage implements OutboxStorage {
  constructor(private readonly database: IDBDatabase) {}

  load(): Promise<OutboxEntry[]> {
    return result(this.store('readonly').getAll() as IDBRequest<OutboxEntry[]>);
  }

  put(entry: OutboxEntry): void {
    this.store('readwrite').put(entry);
  }

  remove(id: string): void {
    this.store('readwrite').delete(id);
  }

  private store(mode: IDBTransactionMode): IDBObjectStore {
    return this.database.transaction(STORE, mode).objectStore(STORE);
  }
}

function openDatabase(): Promise<IDBDatabase> {
  const request = indexedDB.open(NAME, 1);
  request.onupgradeneeded = () => {
    request.result.createObjectStore(STORE, { keyPath: 'id' });
  };
  return result(request);
}

function result<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error ?? new Error('IndexedDB failed'));
  });
}
