# The command alone, linked statically: docker run --rm -v "$PWD:/data" acerra focus flight.toml -o products
FROM rust:1-alpine AS build
RUN apk add --no-cache musl-dev
WORKDIR /source
COPY . .
RUN cargo build --release --locked --package acerra

FROM scratch
COPY --from=build /source/target/release/acerra /acerra
WORKDIR /data
ENTRYPOINT ["/acerra"]
