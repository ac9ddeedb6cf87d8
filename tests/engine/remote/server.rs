//! As much of an S3 server as the engine asks of one, in memory, with the faults that real ones have.

use std::{
    collections::BTreeMap,
    io::{BufRead as _, BufReader, Read as _, Write as _},
    net::{TcpListener, TcpStream},
    sync::{Arc, Mutex},
    time::Duration,
};

/// How it behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mood {
    Well,
    /// Knows no one.
    RefusesAll,
    RefusesWrites,
    NoBucket,
    /// Takes requests and never answers.
    Silent,
    /// Closes the connection in the middle of every answer and takes no more.
    Dying,
}

struct State {
    mood: Mood,
    objects: BTreeMap<String, Vec<u8>>,
    /// Requests that are answered as if all were well, before the mood counts.
    patience: usize,
    requests: usize,
}

#[derive(Clone)]
pub struct Server {
    state: Arc<Mutex<State>>,
    pub endpoint: String,
}

impl Server {
    pub fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let endpoint = format!("http://{}", listener.local_addr().unwrap());
        let state = State { mood: Mood::Well, objects: BTreeMap::new(), patience: 0, requests: 0 };
        let server = Self { state: Arc::new(Mutex::new(state)), endpoint };
        let own = server.clone();
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let own = own.clone();
                std::thread::spawn(move || own.serve(stream));
            }
        });
        server
    }

    /// Behaves so after `patience` more requests.
    pub fn becomes(&self, mood: Mood, patience: usize) {
        let mut state = self.state.lock().unwrap();
        (state.mood, state.patience) = (mood, patience);
    }

    pub fn objects(&self) -> BTreeMap<String, Vec<u8>> {
        self.state.lock().unwrap().objects.clone()
    }

    pub fn requests(&self) -> usize {
        self.state.lock().unwrap().requests
    }

    fn serve(&self, stream: TcpStream) -> Option<()> {
        let mut reader = BufReader::new(stream.try_clone().ok()?);
        let mut out = stream;
        loop {
            let mut line = String::new();
            reader.read_line(&mut line).ok().filter(|n| *n > 0)?;
            let mut words = line.split_whitespace();
            let (method, path) = (words.next()?.to_owned(), words.next()?.to_owned());
            let mut headers = BTreeMap::new();
            loop {
                let mut line = String::new();
                reader.read_line(&mut line).ok()?;
                let Some((name, value)) = line.trim().split_once(':') else { break };
                headers.insert(name.to_lowercase(), value.trim().to_owned());
            }
            let length: usize = headers.get("content-length").map_or(0, |n| n.parse().unwrap());
            let mut body = vec![0; length];
            reader.read_exact(&mut body).ok()?;
            let (status, code, answer, dies) = self.answer(&method, &path, &headers, body)?;
            let answer = match code {
                "" => answer,
                code => format!("<Error><Code>{code}</Code><Message>because of {code}</Message></Error>").into_bytes(),
            };
            let head = format!(
                "HTTP/1.1 {status}\r\nContent-Length: {}\r\nETag: \"1\"\r\nLast-Modified: Sat, 01 Jan 2000 00:00:00 GMT\r\n\r\n",
                answer.len()
            );
            out.write_all(head.as_bytes()).ok()?;
            let sent = if dies { answer.len() / 2 } else { answer.len() };
            if method != "HEAD" {
                out.write_all(&answer[..sent]).ok()?;
            }
            if dies {
                return None;
            }
        }
    }

    /// Status, error code, body, and whether the connection breaks in the middle of it; `None`: it ends at once.
    fn answer(
        &self,
        method: &str,
        path: &str,
        headers: &BTreeMap<String, String>,
        body: Vec<u8>,
    ) -> Option<(&'static str, &'static str, Vec<u8>, bool)> {
        let mut state = self.state.lock().unwrap();
        state.requests += 1;
        let mood = if state.patience > 0 { Mood::Well } else { state.mood };
        state.patience = state.patience.saturating_sub(1);
        let writes = method == "PUT";
        match mood {
            Mood::RefusesAll => return Some(("403 Forbidden", "InvalidAccessKeyId", Vec::new(), false)),
            Mood::RefusesWrites if writes => return Some(("403 Forbidden", "AccessDenied", Vec::new(), false)),
            Mood::NoBucket => return Some(("404 Not Found", "NoSuchBucket", Vec::new(), false)),
            Mood::Silent => {
                drop(state);
                std::thread::sleep(Duration::from_secs(60));
                return None;
            }
            _ => {}
        }
        let dies = mood == Mood::Dying;
        if writes && dies {
            return None;
        }
        if writes {
            if headers.contains_key("if-none-match") && state.objects.contains_key(path) {
                return Some(("412 Precondition Failed", "PreconditionFailed", Vec::new(), false));
            }
            state.objects.insert(path.to_owned(), body);
            return Some(("200 OK", "", Vec::new(), false));
        }
        match state.objects.get(path) {
            Some(bytes) => Some(("200 OK", "", bytes.clone(), dies)),
            None => Some(("404 Not Found", "NoSuchKey", Vec::new(), false)),
        }
    }
}

/// Makes a bucket on a real server that asks for no signature.
pub fn make_bucket(endpoint: &str, bucket: &str) {
    let host = endpoint.strip_prefix("http://").expect("http://HOST:PORT");
    let mut stream = TcpStream::connect(host).unwrap();
    let request = format!("PUT /{bucket} HTTP/1.1\r\nHost: {host}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
}
