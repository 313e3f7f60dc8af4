//! Pages of the book: prose written by hand, blocks and pictures written by code.
//!
//! A block stands between `<!-- begin NAME -->` and `<!-- end NAME -->`. With `ACERRA_DOCS` naming
//! the book's folder, blocks and pictures are written there; without, they are compared with what
//! is committed: words to the letter, numbers to one unit of their last printed digit (another
//! processor adds up in another order), pictures pixel by pixel.

use std::path::{Path, PathBuf};

/// Mean difference of colour values, 0 to 255, that two renderings of a picture may have.
const MEAN_DIFFERENCE: f64 = 0.5;

pub struct Page {
    name: &'static str,
    folder: PathBuf,
    text: String,
    write: bool,
    wrong: Vec<String>,
}

impl Page {
    pub fn open(name: &'static str) -> Self {
        let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/validation");
        let asked = std::env::var_os("ACERRA_DOCS").map(PathBuf::from);
        let write = asked.is_some();
        let folder = asked.unwrap_or(committed);
        let text = std::fs::read_to_string(folder.join(name)).unwrap();
        Self {
            name,
            folder,
            text,
            write,
            wrong: Vec::new(),
        }
    }

    /// Puts `content` into the block `key`, or compares it with what stands there.
    pub fn block(&mut self, key: &str, content: &str) {
        let (begin, end) = (
            format!("<!-- begin {key} -->"),
            format!("<!-- end {key} -->"),
        );
        let place = self.text.find(&begin).zip(self.text.find(&end));
        let (from, to) = place.unwrap_or_else(|| panic!("{}: no block {key}", self.name));
        let from = from + begin.len();
        let content = format!("\n{}\n", minus(content.trim_end()));
        if self.write {
            self.text.replace_range(from..to, &content);
            return;
        }
        let (old, new) = (self.text[from..to].lines(), content.lines());
        let count = |t: &str| t.lines().count();
        if count(&self.text[from..to]) != count(&content) {
            self.wrong.push(format!(
                "{key}: other lines than the code gives:\n{content}"
            ));
        }
        for (old, new) in old.zip(new).filter(|(old, new)| !alike(old, new)) {
            self.wrong
                .push(format!("{key}:\n  committed {old}\n  computed  {new}"));
        }
    }

    /// The picture `name`.png at half its size, written or compared.
    pub fn picture(&mut self, name: &str, png: &[u8]) {
        self.keep(name, &Rgb::decode(png).reduced(2));
    }

    /// The same at one part in `factor` of its size and in few colours, for pictures full of
    /// speckle, which would be large otherwise.
    pub fn speckled_picture(&mut self, name: &str, png: &[u8], factor: usize) {
        self.keep(name, &Rgb::decode(png).reduced(factor).in_few_colours());
    }

    fn keep(&mut self, name: &str, picture: &Rgb) {
        let path = self.folder.join("images").join(format!("{name}.png"));
        if self.write {
            std::fs::write(&path, picture.encode()).unwrap();
            return;
        }
        let Ok(committed) = std::fs::read(&path) else {
            self.wrong.push(format!("{} is missing", path.display()));
            return;
        };
        let committed = Rgb::decode(&committed);
        match picture.mean_difference(&committed) {
            Some(difference) if difference <= MEAN_DIFFERENCE => {}
            Some(difference) => self.wrong.push(format!(
                "{name}.png differs by {difference:.2} of 255 on average"
            )),
            None => self.wrong.push(format!("{name}.png has another size")),
        }
    }

    /// Writes the page, or fails where it is not what the code gives.
    pub fn close(self) {
        if self.write {
            std::fs::write(self.folder.join(self.name), self.text).unwrap();
        }
        assert!(
            self.wrong.is_empty(),
            "docs/validation/{} is not what the code gives (cargo xtask book writes it again):\n{}",
            self.name,
            self.wrong.join("\n")
        );
    }
}

/// Hyphens before digits as minus signs.
pub fn minus(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut before = ' ';
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        let digit = letters.peek().is_some_and(char::is_ascii_digit);
        out.push(if letter == '-' && digit && !before.is_alphanumeric() {
            '−'
        } else {
            letter
        });
        before = letter;
    }
    out
}

/// Whether two lines agree: words to the letter, numbers to a unit of the last digit.
fn alike(a: &str, b: &str) -> bool {
    let (a, b) = (pieces(a), pieces(b));
    a.len() == b.len()
        && a.iter().zip(&b).all(|pair| match pair {
            (Piece::Number(x, p), Piece::Number(y, q)) => {
                p == q && (x - y).abs() <= 1.001 * 10_f64.powi(-p)
            }
            (x, y) => x == y,
        })
}

#[derive(Debug, PartialEq)]
enum Piece {
    Word(String),
    /// Value and decimals.
    Number(f64, i32),
}

fn pieces(line: &str) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let mut word = String::new();
    let letters: Vec<char> = line.chars().collect();
    let mut i = 0;
    while i < letters.len() {
        let digit = |k: usize| letters.get(k).is_some_and(char::is_ascii_digit);
        let sign = matches!(letters[i], '-' | '−' | '+') && digit(i + 1);
        let after_word = i > 0 && letters[i - 1].is_alphanumeric();
        if (digit(i) || sign) && !after_word {
            let negative = matches!(letters[i], '-' | '−');
            let mut end = i + usize::from(sign);
            while digit(end) || (letters.get(end) == Some(&'.') && digit(end + 1)) {
                end += 1;
            }
            let number: String = letters[i + usize::from(sign)..end].iter().collect();
            let decimals = number.split_once('.').map_or(0, |(_, d)| d.len());
            if let Ok(value) = number.parse::<f64>() {
                pieces.push(Piece::Word(std::mem::take(&mut word)));
                let value = if negative { -value } else { value };
                pieces.push(Piece::Number(value, i32::try_from(decimals).unwrap()));
                i = end;
                continue;
            }
        }
        word.push(letters[i]);
        i += 1;
    }
    pieces.push(Piece::Word(word));
    pieces
}

/// A picture of eight bits a colour.
struct Rgb {
    width: usize,
    height: usize,
    values: Vec<u8>,
}

impl Rgb {
    fn decode(bytes: &[u8]) -> Self {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut values = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut values).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        values.truncate(info.buffer_size());
        Self {
            width: info.width as usize,
            height: info.height as usize,
            values,
        }
    }

    fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let size = [self.width, self.height].map(|n| u32::try_from(n).unwrap());
        let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(png::Filter::Adaptive);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&self.values).unwrap();
        writer.finish().unwrap();
        bytes
    }

    /// Means of `factor` by `factor` pixels.
    fn reduced(&self, factor: usize) -> Self {
        let (width, height) = (self.width / factor, self.height / factor);
        let mut values = Vec::with_capacity(3 * width * height);
        let count = factor * factor;
        for y in 0..height {
            for x in 0..width {
                for c in 0..3 {
                    let at = |k: usize| {
                        let (x, y) = (factor * x + k % factor, factor * y + k / factor);
                        usize::from(self.values[3 * (y * self.width + x) + c])
                    };
                    let sum: usize = (0..count).map(at).sum();
                    values.push(u8::try_from((sum + count / 2) / count).unwrap());
                }
            }
        }
        Self {
            width,
            height,
            values,
        }
    }

    /// Sixteen steps from black to white.
    fn in_few_colours(mut self) -> Self {
        for value in &mut self.values {
            *value = 17 * u8::try_from((u16::from(*value) + 8) / 17).unwrap();
        }
        self
    }

    fn mean_difference(&self, other: &Self) -> Option<f64> {
        let same = (self.width, self.height) == (other.width, other.height);
        same.then(|| {
            let pairs = self.values.iter().zip(&other.values);
            let sum: u64 = pairs.map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
            sum as f64 / self.values.len() as f64
        })
    }
}

#[test]
fn lines_agree_to_the_last_digit() {
    assert!(alike("| −22.8 dB | 0.0408 |", "| -22.9 dB | 0.0409 |"));
    assert!(alike("(0.00, ±1.397)", "(-0.00, ±1.398)"));
    assert!(!alike("| 0.0408 |", "| 0.041 |"));
    assert!(!alike("| 0.0408 |", "| 0.0410 |"));
    assert!(!alike("Track 1 fixed", "Track 1 float"));
    assert!(!alike("| 3 |", "| – |"));
}

#[test]
fn pictures_are_compared_by_their_pixels() {
    let picture = |shade: u8| Rgb {
        width: 2,
        height: 2,
        values: vec![shade; 12],
    };
    let back = Rgb::decode(&picture(7).encode());
    assert_eq!(picture(7).mean_difference(&back), Some(0.0));
    assert_eq!(picture(7).mean_difference(&picture(9)), Some(2.0));
    assert_eq!(picture(7).mean_difference(&picture(9).reduced(2)), None);
}
