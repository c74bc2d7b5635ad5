// Sends a file of a submission, and goes on where a connection broke.
import { text } from './text';

const tries = 5;

interface Answer {
  status: number;  // 0: none came
  body: Record<string, any>;
}

/** fetch shows no progress of what it sends. */
function send(url: string, part: Blob, progress: (sent: number) => void): Promise<Answer> {
  return new Promise((resolve) => {
    const request = new XMLHttpRequest();
    request.open('POST', url);
    request.upload.onprogress = (event) => progress(event.loaded);
    request.onloadend = () => {
      let body = {};
      try {
        body = JSON.parse(request.responseText);
      } catch {
        // There is none.
      }
      resolve({ status: request.status, body });
    };
    request.send(part);
  });
}

/** "" when it is there whole, else why not. */
export async function sendFile(id: string, file: File,
                               progress: (sent: number) => void): Promise<string> {
  const url = `/api/v1/submissions/${id}/files/${encodeURIComponent(file.name)}`;
  for (let attempt = 0; attempt < tries; ++attempt) {
    let offset = 0;
    try {
      const before = await fetch(url);
      const there = before.ok ? await before.json() : {};
      if (there.complete) return '';
      if (there.size_bytes === file.size) offset = there.received_bytes ?? 0;
    } catch {
      // The next request shows whether there is a connection.
    }
    const answer = await send(`${url}?offset=${offset}&size=${file.size}`, file.slice(offset),
      (sent) => progress(offset + sent));
    if (answer.status === 200 && answer.body.complete) return '';
    if (answer.status !== 0 && answer.status !== 200) return answer.body.message ?? text.lost;
    await new Promise((done) => setTimeout(done, 500 * 2 ** attempt));
  }
  return text.lost;
}
