//! The guide's gallery: runs the commands that its page states and takes the pictures that they leave.

use std::fs::{self, File};
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};

use crate::runner::{Runner, Step};

/// Folder of the guide's pages.
const PAGES: &str = "docs/guide/src";

/// Most bytes of all pictures together.
const MOST_BYTES: u64 = 1_500_000;

/// What the page asks for, in its order.
#[derive(Debug, PartialEq)]
enum Part {
    /// A settings file: its name and text.
    File(String, String),
    /// Lines for the shell.
    Commands(String),
    /// `gallery/RUN-NAME.png`: the picture `RUN/NAME.png`.
    Picture(String),
}

/// Makes the pictures of the page again.
pub fn write(runner: &Runner) -> anyhow::Result<()> {
    let build = ["cargo", "build", "--locked", "-p", "acerra"];
    runner.run(&Step::new("the program", &build))?;
    let here = runner.target().join("gallery");
    let _ = fs::remove_dir_all(&here);
    fs::create_dir_all(&here)?;
    let page = runner.root.join(PAGES).join("gallery.md");
    let text = fs::read_to_string(&page).with_context(|| page.display().to_string())?;
    let program = runner.target().join("debug");
    let path = std::env::var("PATH").unwrap_or_default();
    let path = format!("{}:{path}", program.display());
    let pictures = runner.root.join(PAGES).join("gallery");
    fs::create_dir_all(&pictures)?;
    let mut bytes = 0;
    for part in parts(&text) {
        match part {
            Part::File(name, text) => fs::write(here.join(name), under(&runner.root, &text))?,
            Part::Commands(lines) => {
                let shell = ["sh", "-e", "-c", &lines];
                let step = Step::new("a product", &shell).with("PATH", path.as_str());
                runner.run(&step.within(here.clone()))?;
            }
            Part::Picture(name) => {
                let product = product(&here, &name)?;
                let picture = pictures.join(name);
                halve(&product, &picture).with_context(|| product.display().to_string())?;
                bytes += fs::metadata(picture)?.len();
            }
        }
    }
    ensure!(
        bytes <= MOST_BYTES,
        "expected at most {MOST_BYTES} bytes of pictures, found {bytes}"
    );
    println!("{bytes} bytes of pictures in {}", pictures.display());
    Ok(())
}

/// The product of a picture's name: `two-image.png` is `two/image.png`.
fn product(here: &Path, name: &str) -> anyhow::Result<PathBuf> {
    let (run, product) = name
        .split_once('-')
        .with_context(|| format!("{name}: expected RUN-PRODUCT.png"))?;
    Ok(here.join(run).join(product))
}

/// Writes a picture at half its size: each pixel is the mean of four, in steps of eight, which halves the bytes.
fn halve(from: &Path, to: &Path) -> anyhow::Result<()> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(from)?)).read_info()?;
    let info = reader.info();
    let form = (info.color_type, info.bit_depth);
    ensure!(
        form == (png::ColorType::Rgb, png::BitDepth::Eight),
        "expected 8 bits each of red, green and blue, found {form:?}"
    );
    let [width, height] = [info.width as usize, info.height as usize];
    let mut values = vec![0; 3 * width * height];
    reader.next_frame(&mut values)?;
    let [columns, rows] = [width / 2, height / 2];
    let mean = |k: usize| {
        let (row, column, colour) = (k / (3 * columns), k / 3 % columns, k % 3);
        let at = |dy: usize, dx: usize| {
            let pixel = (2 * row + dy) * width + 2 * column + dx;
            u16::from(values[3 * pixel + colour])
        };
        let sum = at(0, 0) + at(0, 1) + at(1, 0) + at(1, 1);
        u8::try_from((sum + 16) / 32 * 8).unwrap_or(u8::MAX)
    };
    let halved: Vec<u8> = (0..3 * columns * rows).map(mean).collect();
    let writer = BufWriter::new(File::create(to)?);
    let mut encoder = png::Encoder::new(writer, u32::try_from(columns)?, u32::try_from(rows)?);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    encoder.write_header()?.write_image_data(&halved)?;
    Ok(())
}

/// Files of the repository that a campaign names are where the repository is.
fn under(root: &Path, campaign: &str) -> String {
    campaign.replace("\"docs/", &format!("\"{}/docs/", root.display()))
}

/// Settings files, commands and pictures of a page. A settings file's first line is its name as a comment.
fn parts(page: &str) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            let block: Vec<&str> = lines.by_ref().take_while(|l| *l != "```").collect();
            let text = block.join("\n") + "\n";
            let name = block.first().and_then(|first| first.strip_prefix("# "));
            match (language, name) {
                ("sh", _) => parts.push(Part::Commands(text)),
                ("toml", Some(name)) => parts.push(Part::File(name.to_owned(), text)),
                _ => {}
            }
        } else if let Some((_, rest)) = line.split_once("](gallery/") {
            let name = rest.trim_end_matches(')');
            parts.push(Part::Picture(name.to_owned()));
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_files_commands_and_pictures_in_its_order() {
        let page = "# Gallery\n```toml\n# a.toml\n[image]\n```\nText\n```sh\nacerra focus a.toml -o a\n```\n\
                    ```text\nnot run\n```\n![An image](gallery/a-image.png)\n";
        let expected = [
            Part::File("a.toml".to_owned(), "# a.toml\n[image]\n".to_owned()),
            Part::Commands("acerra focus a.toml -o a\n".to_owned()),
            Part::Picture("a-image.png".to_owned()),
        ];
        assert_eq!(parts(page), expected);
        let found = product(Path::new("/here"), "map-resolution-map.png").unwrap();
        assert_eq!(found, Path::new("/here/map/resolution-map.png"));
    }

    #[test]
    fn the_guides_page_shows_nine_products_that_are_there() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(PAGES);
        let page = fs::read_to_string(root.join("gallery.md")).unwrap();
        let names = parts(&page).into_iter().filter_map(|part| match part {
            Part::Picture(name) => Some(root.join("gallery").join(name)),
            _ => None,
        });
        let bytes: Vec<u64> = names
            .map(|name| fs::metadata(name).unwrap().len())
            .collect();
        assert_eq!(bytes.len(), 9);
        assert!(bytes.iter().sum::<u64>() <= MOST_BYTES, "{bytes:?}");
    }
}
